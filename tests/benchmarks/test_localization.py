"""The benchmark of localization: what counts as found and as a false alarm, and a short drive."""

import numpy as np

from benchmarks.localization.__main__ import false_alarms, jumps_found, of_the_worst
from benchmarks.localization.campus_way import beside, campus_way, truths
from benchmarks.localization.drive import CONDITIONS, Drive, drive
from benchmarks.localization.sensed_drive import kidnapped
from campusloop.shipped import DEFAULT_MAP
from contract.roads.load import load_map
from vehicle_agent.localization.gnss_ins import GnssInsLocalization


def a_drive(error_m: list[float], drivable: list[int], wrong: list[int]) -> Drive:
    """Each value for half a second."""
    rows = [np.repeat(np.array(row, dtype=np.float64), 25) for row in (error_m, drivable, wrong)]
    nothing = np.zeros(len(rows[0]))
    return Drive(rows[0], nothing, nothing, nothing, rows[1], rows[2])


def test_a_jump_is_found_if_it_is_told_in_time_or_does_no_harm() -> None:
    wrong = [0, 1, 1, 1, 1, 1, 1, 1, 1, 0, 0, 0, 0, 0]
    harmless = a_drive([0.1] * 14, [1] * 14, wrong)
    told = a_drive([0.1] + [3.0] * 13, [1, 1, 1, 1] + [0] * 10, wrong)
    late = a_drive([0.1] + [3.0] * 13, [1] * 6 + [0] * 8, wrong)
    assert [jumps_found(one) for one in (harmless, told, late)] == [[True], [True], [False]]


def test_a_false_alarm_is_one_that_is_raised_at_the_right_place() -> None:
    assert false_alarms(a_drive([0.05] * 6, [0, 1, 0, 0, 1, 1], [0] * 6)) == 1
    assert false_alarms(a_drive([0.05, 0.05, 0.5, 0.6, 0.05, 0.05], [1, 1, 0, 0, 1, 1], [0] * 6)) == 0


def test_figures_of_all_stacks_are_those_of_the_worst_one_with_its_scans() -> None:
    stacks = {
        "gem_gnss": (90.0, 3.0, 70.0),
        "gem": (100.0, 0.0, 96.0),
        "nus": (99.0, 1.0, 99.0),
    }
    names = ("lost_found_pct", "false_alarms_per_10h", "nees_in_bounds_pct")
    summary = {
        f"{stack}.{name}": value
        for stack, values in stacks.items()
        for name, value in zip(names, values, strict=True)
    }
    assert of_the_worst(summary) == dict(zip(names, (99.0, 1.0, 96.0), strict=True))
    alone = {key: value for key, value in summary.items() if key.startswith("gem_gnss")}
    assert of_the_worst(alone) == dict(zip(names, stacks["gem_gnss"], strict=True))


def test_odometry_without_errors_ends_where_the_vehicle_is() -> None:
    """The drive's own motion is consistent, or no filter could follow it."""
    way = campus_way(load_map(DEFAULT_MAP), 0.3, 3.0, np.random.default_rng(2))
    x_m = y_m = 0.0
    views = list(truths(way, 0.01))
    for view in views:
        course = view.pose_map.yaw_rad + 0.5 * view.yaw_rate_radps * 0.02
        slip_rad = 0.01 * view.speed_mps * view.yaw_rate_radps
        x_m += 0.02 * view.speed_mps * np.cos(course - slip_rad)
        y_m += 0.02 * view.speed_mps * np.sin(course - slip_rad)
    first, last = views[0].pose_map, views[-1].pose_map
    assert np.hypot(last.x_m - first.x_m - x_m, last.y_m - first.y_m - y_m) < 0.3


def test_a_short_drive_between_buildings_stays_near_the_truth() -> None:
    road_map = load_map(DEFAULT_MAP)
    way = campus_way(road_map, 0.3, 3.0, np.random.default_rng(2))
    room = GnssInsLocalization(road_map.origin)
    one = drive(truths(way, 0.0), room, road_map, CONDITIONS[1], 1)
    settled = one.error_m[len(one.error_m) // 2 :]
    assert float(np.sqrt(np.mean(settled**2))) < 0.1


def test_the_opposite_lane_is_the_way_back_and_keeps_its_distance() -> None:
    way = campus_way(load_map(DEFAULT_MAP), 0.3, 3.0, np.random.default_rng(2))
    back = beside(way, 250.0, 3.2, back=True)
    apart_m = np.array([np.hypot(*(way.points - point).T).min() for point in back.points])
    assert np.median(apart_m) > 3.0
    assert apart_m.max() < 5.0
    assert np.hypot(*(back.points[-1] - way.points[0])) < 4.0
    assert back.speed_mps.max() <= 3.0


def test_a_kidnapping_is_noticed_within_2_s_and_right_when_it_is_right() -> None:
    def became(error_m: list[float], drivable: list[int]) -> list[tuple[bool, float]]:
        # The drive goes on for longer than is waited for.
        rest = 50 - len(error_m)
        one = a_drive(error_m + [error_m[-1]] * rest, drivable + [drivable[-1]] * rest, [0] * 50)
        return [(found.is_noticed, found.right_s) for found in kidnapped(one, [50])]

    assert became([0.1, 0.1] + [5.0] * 10 + [0.1], [1] * 5 + [0] * 8) == [(True, 5.0)]
    assert became([0.1, 0.1] + [5.0] * 10 + [0.1], [1] * 7 + [0] * 6) == [(False, 5.0)]
    assert became([0.1, 0.1, 5.0], [1, 1, 0]) == [(True, np.inf)], "told, and never found"
    assert became([0.1, 0.1, 5.0, 0.1], [1]) == [(True, 0.5)], "right again before it was told"
    assert kidnapped(a_drive([0.1] * 4, [1] * 4, [0] * 4), [50]) == (), "too near to the end"
