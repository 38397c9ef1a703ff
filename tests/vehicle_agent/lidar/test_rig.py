"""Several lidars are one scan of the vehicle. Without a required one it is blind."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from contract.transforms import transform_of
from vehicle_agent.lidar.rig import SILENT, LidarRig, RigLidar, RigScan
from vehicle_agent.signals.point_cloud import PointCloud, point_cloud

MS = 1_000_000
TURN_NS = 100 * MS
FRONT = transform_of(0.0, 0.0, 0.0, np.array([3.0, 0.0, 1.5]))
REAR = transform_of(0.0, 0.0, np.pi, np.array([-0.5, 0.0, 1.5]))


def a_turn(stamp_ns: int, seed: int = 0, count: int = 400) -> PointCloud:
    rng = np.random.default_rng([seed, stamp_ns // MS])
    points = rng.uniform(-20.0, 20.0, (count, 3))
    offsets = np.linspace(0, TURN_NS, count).astype(np.int64)
    return point_cloud(stamp_ns, points, rng.uniform(0.0, 200.0, count), offsets_ns=offsets)


def a_rig(rear_is_required: bool = True) -> LidarRig:
    return LidarRig([RigLidar("front", FRONT), RigLidar("rear", REAR, rear_is_required)])


def last(rig: LidarRig, names: str, begin_ns: int = 0, turns: int = 5) -> RigScan | None:
    """The newest scan after these lidars have turned."""
    found = None
    for turn in range(turns):
        for offset, name in enumerate(names.split()):
            cloud = a_turn(begin_ns + turn * TURN_NS + offset * MS, seed=offset)
            found = rig.add(name, cloud) or found
    return found


def test_points_of_all_lidars_are_in_the_vehicles_frame() -> None:
    scan = last(a_rig(), "rear front")
    assert scan is not None
    assert not scan.is_blind
    assert scan.missing == {}
    assert len(scan.points_base) == 800
    assert scan.stamp_ns == 4 * TURN_NS + MS + TURN_NS
    ahead = a_turn(4 * TURN_NS + MS, seed=1).points_sensor
    assert scan.points_base[:400] == pytest.approx(ahead + FRONT[:3, 3], abs=1e-5)
    behind = a_turn(4 * TURN_NS, seed=0).points_sensor
    assert scan.points_base[400:] == pytest.approx(behind * [-1.0, -1.0, 1.0] + REAR[:3, 3], abs=1e-4)


def test_there_is_one_scan_a_turn() -> None:
    rig = a_rig()
    scans = [
        rig.add(name, a_turn(k * TURN_NS + (name == "rear"))) for k in range(10) for name in ("front", "rear")
    ]
    given_ns = [scan.stamp_ns for scan in scans if scan is not None]
    assert len(given_ns) == 10
    assert np.diff(given_ns).tolist() == [TURN_NS] * 9


def test_a_required_lidar_that_is_silent_makes_the_vehicle_blind_and_names_itself() -> None:
    rig = a_rig()
    last(rig, "front rear")
    scan = last(rig, "front", begin_ns=5 * TURN_NS, turns=4)
    assert scan is not None
    assert scan.is_blind
    assert len(scan.points_base) == 0
    assert scan.missing == {"rear": SILENT}
    back = last(rig, "rear front", begin_ns=9 * TURN_NS, turns=1)
    assert back is not None
    assert not back.is_blind


def test_without_an_optional_lidar_the_others_see_on() -> None:
    rig = a_rig(rear_is_required=False)
    last(rig, "front rear")
    scan = last(rig, "front", begin_ns=5 * TURN_NS)
    assert scan is not None
    assert not scan.is_blind
    assert len(scan.points_base) == 400
    assert scan.missing == {"rear": SILENT}


def test_when_the_leading_lidar_dies_another_leads_and_says_so() -> None:
    rig = a_rig()
    last(rig, "front rear")
    scan = last(rig, "rear", begin_ns=5 * TURN_NS)
    assert scan is not None
    assert scan.is_blind
    assert scan.missing == {"front": SILENT}


def test_when_all_are_silent_the_vehicle_is_told_that_it_is_blind() -> None:
    rig = a_rig()
    assert rig.silence(0) is None
    last(rig, "front rear", begin_ns=TURN_NS)
    end_ns = 7 * TURN_NS
    assert rig.silence(end_ns) is None
    scan = rig.silence(end_ns + 301 * MS)
    assert scan is not None
    assert scan.is_blind
    assert scan.missing == {"front": SILENT, "rear": SILENT}


@pytest.mark.parametrize(
    ("code", "broken"),
    [
        ("empty", lambda cloud: cloud.selected(np.arange(20))),
        ("frozen", lambda cloud: a_turn(0).selected(np.arange(400))),
        (
            "too_near",
            lambda cloud: point_cloud(cloud.stamp_ns, 0.01 * cloud.points_sensor, cloud.intensities),
        ),
        ("saturated", lambda cloud: point_cloud(cloud.stamp_ns, cloud.points_sensor, np.full(400, 255.0))),
        (
            "not_finite",
            lambda cloud: point_cloud(cloud.stamp_ns, cloud.points_sensor * np.nan, cloud.intensities),
        ),
    ],
)
def test_turns_that_no_working_lidar_gives_are_left_out_by_their_code(code: str, broken: object) -> None:
    rig = a_rig(rear_is_required=False)
    last(rig, "front rear")
    scan = None
    for turn in range(5, 10):
        rig.add("rear", broken(a_turn(turn * TURN_NS, seed=1)))  # type: ignore[operator]
        scan = rig.add("front", a_turn(turn * TURN_NS + MS)) or scan
    assert scan is not None
    assert scan.missing == {"rear": code}
    assert np.isfinite(scan.points_base).all()


@given(st.lists(st.tuples(st.sampled_from(["front", "rear"]), st.integers(1, 400)), max_size=40))
def test_whatever_comes_no_scan_with_points_lacks_a_required_lidar(turns: list[tuple[str, int]]) -> None:
    rig, now_ns = a_rig(), 0
    ended_ns = {"front": -TURN_NS * 100, "rear": -TURN_NS * 100}
    for name, after_ms in turns:
        now_ns += after_ms * MS
        ended_ns[name] = now_ns + TURN_NS
        scan = rig.add(name, a_turn(now_ns))
        if scan is not None and not scan.is_blind:
            assert all(scan.stamp_ns - end_ns <= 300 * MS for end_ns in ended_ns.values())
            assert len(scan.points_base) == 800
