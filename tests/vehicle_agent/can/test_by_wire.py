"""Each profile's by-wire as the gate has it: it hears the module and can brake it."""

from pathlib import Path

import pytest

from tests.simulator.ecus.can_driver import CanDriver
from vehicle_agent.can.by_wire import braking_of, motion_reports_of
from vehicle_agent.config import load_profile
from vehicle_agent.signals import Actuation

PROFILES = sorted((Path(__file__).resolve().parents[3] / "vehicle_agent" / "profiles").glob("*.toml"))
assert len(PROFILES) >= 3


@pytest.mark.parametrize("path", PROFILES, ids=lambda path: str(path.stem))
def test_what_the_module_reports_reaches_the_gate(path: Path) -> None:
    driver = CanDriver(load_profile(path))
    driver.run(4.0, Actuation(True, "drive", 0.2, 0.3, 0.0))
    motion = motion_reports_of(driver.profile).decode(tuple(driver.heard), driver.now_ns)
    truth = driver.fleet.truth("s1")
    assert motion.enabled
    assert motion.steer_rad == pytest.approx(truth.steer_rad, abs=0.02)
    assert motion.speed_mps == pytest.approx(truth.speed_mps, abs=0.1)
    assert motion.speed_mps > 0.5


@pytest.mark.parametrize("path", PROFILES, ids=lambda path: str(path.stem))
def test_the_gate_reads_what_the_tick_tells_the_module(path: Path) -> None:
    driver = CanDriver(load_profile(path))
    act = Actuation(True, "drive", 0.2, 0.3, 0.0)
    driver.run(4.0, act)
    frames, _ = driver.can.encode(driver.state, act, driver.now_ns)
    commanded = braking_of(driver.profile).commanded(frames)
    assert commanded.enable
    assert commanded.steer_rad == pytest.approx(0.2, abs=0.02)
    assert commanded.throttle_ratio == pytest.approx(0.3, abs=0.01)
