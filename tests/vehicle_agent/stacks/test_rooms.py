"""What the rooms that stacks share take from the profile."""

from pathlib import Path

import msgspec
import pytest

from simulator.world import WorldOptions
from tests.vehicle_agent.driven_shuttle import DrivenShuttle
from tests.vehicle_agent.mission.ring import ring
from vehicle_agent.config import Announcing, LidarMount, Profile, ProfileError, load_profile
from vehicle_agent.stacks.rooms import announcer, guard

NO_LIDAR = LidarMount(rate_hz=0.0)
START, STOP = ("south", 5.0), ("north", 30.0)


def test_the_announcer_speaks_as_its_profile_wants() -> None:
    announcing = Announcing(
        stopping_m=35.0, ahead_m=6.0, step_aside_s=20.0, aside_again_s=15.0, courtesy_s=90.0
    )
    room = announcer(Profile(announcing=announcing))
    assert (room.stopping_m, room.attention.ahead_m) == (35.0, 6.0)
    assert room.step_aside_ns == 20_000_000_000
    assert room.aside_again_ns == 15_000_000_000
    assert room.courtesy_ns == 90_000_000_000


@pytest.mark.parametrize("line", ["step_aside_s = 0.0", "courtesy_s = -3.0", "stopping_m = nan", "hush = 1"])
def test_a_profile_with_impossible_announcements_is_refused_by_name(line: str, tmp_path: Path) -> None:
    path = tmp_path / "vehicle.toml"
    path.write_text(f"[announcing]\n{line}\n")
    with pytest.raises(ProfileError, match=line.split()[0]):
        load_profile(path)


@pytest.mark.parametrize(
    ("stack", "lidar", "perception", "expects"),
    [
        ("gem", LidarMount(), "own", True),
        ("gem", NO_LIDAR, "own", False),
        ("gem", NO_LIDAR, "tracker", True),
        ("nus", NO_LIDAR, "tracker", True),
        ("nus", NO_LIDAR, "own", True),
        ("snow_lion", NO_LIDAR, "own", True),
        ("snow_lion", NO_LIDAR, "tracker", True),
    ],
)
def test_percepts_are_expected_of_a_lidar_and_of_a_tracker_alone(
    stack: str, lidar: LidarMount, perception: str, expects: bool
) -> None:
    profile = msgspec.convert({"stack": stack, "perception": perception}, Profile)
    room = guard(msgspec.structs.replace(profile, lidar=lidar))
    assert (room.ageing.percept_ns > 0) is expects


def test_a_vehicle_without_a_lidar_stops_when_its_tracker_falls_silent() -> None:
    profile = msgspec.structs.replace(Profile(stack="nus"), lidar=NO_LIDAR)
    shuttle = DrivenShuttle(ring(), START, profile, WorldOptions(traffic=None, lidar=False))
    rest = shuttle.visit("rest", "north", 70.0, STOP, kind="rest", dwell_s=0.0)
    visits = (shuttle.visit("stop", *STOP, START, dwell_s=5.0), rest)
    shuttle.say(shuttle.order_for(visits, START))
    shuttle.run(1.0)
    shuttle.resume()
    assert shuttle.run(10.0, lambda s: s.world.truth("s1").speed_mps > 1.0)
    shuttle.world.tracked = lambda vehicle_id, now_ns: []  # type: ignore[method-assign]
    shuttle.run(0.6)
    assert shuttle.outputs is not None
    status = shuttle.outputs.flow.guard_status
    assert status.mode == "minimal_risk"
    assert "percept_stale" in {fault.code for fault in status.faults}
    assert shuttle.run(10.0, lambda s: s.world.truth("s1").speed_mps < 0.05)
