"""The first second after a start: reports are on their way, and nothing is wrong yet."""

from pathlib import Path

import pytest

import vehicle_agent
from vehicle_agent.can.by_wire import codec_of
from vehicle_agent.can.module_state import BOOT_GRACE_NS
from vehicle_agent.config import load_profile

PROFILES = sorted((Path(vehicle_agent.__file__).parent / "profiles").glob("*.toml"))
# The computer's clock may have begun with the computer.
BOOT_NS = 10_000_000
LOST = {
    "pacmod": {"global", "accelerator", "brake", "steering", "speed"},
    "servo": {"drive", "brake", "throttle", "steering", "encoder"},
}


@pytest.mark.parametrize("path", PROFILES, ids=[path.stem for path in PROFILES])
def test_every_report_is_missed_a_second_after_the_start_and_none_before(path: Path) -> None:
    profile = load_profile(path)
    codec = codec_of(profile)
    motion, state = codec.decode(codec.initial(), (), BOOT_NS)
    assert motion.faults == ()
    motion, state = codec.decode(state, (), BOOT_NS + BOOT_GRACE_NS)
    assert motion.faults == ()
    motion, state = codec.decode(state, (), BOOT_NS + BOOT_GRACE_NS + 1)
    lost = {f"can_{name}_report_lost" for name in LOST[profile.by_wire.kind]}
    assert {fault.code for fault in motion.faults} == lost
    assert {fault.severity for fault in motion.faults} == {"stop"}
