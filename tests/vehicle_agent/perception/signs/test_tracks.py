"""Signs over scans: one identity each, named by its outline, forgotten behind the vehicle."""

from collections.abc import Iterable, Iterator

import numpy as np
import pytest

from contract.geometry import Pose2
from tests.vehicle_agent.perception.signs.boards_in_scans import (
    LIDAR_Z_M,
    octagon,
    plate,
    point_down,
    returns_of,
    scan_of,
)
from vehicle_agent.perception.signs.boards import SignFinder
from vehicle_agent.perception.signs.evidence import no_evidence, probabilities, with_chords
from vehicle_agent.perception.signs.stages import SignStages
from vehicle_agent.perception.signs.tracks import SignsState, SignTracker, seen_signs
from vehicle_agent.signals import SignPercept

FINDER = SignFinder(SignStages(z_m=LIDAR_Z_M))
TRACKER = SignTracker()
SIGN_X_M = 60.0


def names_on_the_way(
    outline: np.ndarray, to_m: float, bottom_m: float = 2.1, state: SignsState | None = None
) -> Iterator[tuple[float, SignsState]]:
    """(range, what is known of a board) on the way from 24 m to `to_m` before it, every 0.5 m."""
    state = state or SignsState()
    z_m = bottom_m - float(outline[:, 1].min())
    for number, range_m in enumerate(np.arange(24.0, to_m - 0.01, -0.5).tolist()):
        scan = scan_of(returns_of(outline, (range_m, -3.5, z_m), seed=number))
        percept = FINDER.percept(*scan, 100 * (number + 1))
        state = TRACKER.step(state, percept, Pose2(SIGN_X_M - range_m, 0.0, 0.0))
        yield range_m, state


def approached(
    outline: np.ndarray, to_m: float, bottom_m: float = 2.1, state: SignsState | None = None
) -> SignsState:
    """What is known at the end of the way."""
    return [known for _, known in names_on_the_way(outline, to_m, bottom_m, state)][-1]


@pytest.mark.parametrize("bottom_m", [1.95, 2.1, 2.25])
def test_a_stop_sign_is_named_ten_metres_before_it(bottom_m: float) -> None:
    (sign,) = seen_signs(approached(octagon(), 10.0, bottom_m))
    assert sign.kind == "stop"
    assert np.hypot(sign.pose_map.x_m - SIGN_X_M, sign.pose_map.y_m + 3.5) < 0.2


def test_a_yield_sign_is_named_and_keeps_its_name_when_passed() -> None:
    named = [
        seen_signs(state)[0].kind for range_m, state in names_on_the_way(point_down(), 6.0) if range_m <= 10.0
    ]
    assert set(named) == {"yield"}


@pytest.mark.parametrize("outline", [plate(0.6, 0.6), plate(0.75, 0.75), plate(0.9, 0.45)])
def test_no_plate_is_ever_named_stop(outline: np.ndarray) -> None:
    for _, state in names_on_the_way(outline, 6.0):
        assert "stop" not in [sign.kind for sign in seen_signs(state)]


def test_a_board_that_was_seen_once_has_no_name() -> None:
    scan = scan_of(returns_of(octagon(), (7.0, 0.0, 2.5)))
    state = TRACKER.step(SignsState(), FINDER.percept(*scan, 1), Pose2(0.0, 0.0, 0.0))
    assert [sign.kind for sign in seen_signs(state)] == ["board"]


def test_standing_before_an_unclear_board_does_not_make_it_clear() -> None:
    """The same firings meet it in every scan: a hundred of them are no more than a few."""
    state = SignsState()
    scan = scan_of(returns_of(octagon(), (22.0, -3.5, 2.5)))
    percept = FINDER.percept(*scan, 1)
    for number in range(300):
        again = SignPercept(number + 1, percept.boards_base, percept.chords, percept.owners)
        state = TRACKER.step(state, again, Pose2(0.0, 0.0, 0.0))
    assert [sign.kind for sign in seen_signs(state)] == ["board"]


def test_a_sign_keeps_its_id_and_is_forgotten_behind_the_vehicle() -> None:
    state = approached(octagon(), 8.0)
    assert [sign.sign_id for sign in seen_signs(state)] == [1]
    near = TRACKER.step(state, SignPercept(9000), Pose2(SIGN_X_M + 5.0, 0.0, 0.0))
    assert [sign.sign_id for sign in seen_signs(near)] == [1]
    passed = TRACKER.step(near, SignPercept(9100), Pose2(SIGN_X_M + 20.0, 0.0, 0.0))
    assert seen_signs(passed) == ()
    again = approached(octagon(), 20.0, state=passed)
    assert [sign.sign_id for sign in seen_signs(again)] == [2]


def test_boards_without_a_place_are_left_out() -> None:
    percept = SignPercept(
        1, np.full((1, 6), np.nan), np.array([[0.7, 2.4, 2.4, 0.02, 0.0]]), np.zeros(1, np.int64)
    )
    assert seen_signs(TRACKER.step(SignsState(), percept, Pose2(0.0, 0.0, 0.0))) == ()


def chords(*rows: tuple[float, float]) -> np.ndarray:
    return np.array([(width, z, z, 0.02, 0.0) for width, z in rows])


def after(*scans: Iterable[tuple[float, float]]) -> dict[str, float]:
    evidence = no_evidence()
    for rows in scans:
        evidence = with_chords(evidence, chords(*rows), 1.0, 0.0)
    return probabilities(evidence)


def test_probabilities_are_a_distribution_and_follow_the_chords() -> None:
    start = after()
    assert sum(start.values()) == pytest.approx(1.0)
    assert start["octagon"] < 0.5
    # 0.75 m wide in the middle, and narrower by the cut corners above and below.
    clear = after([(0.31, 2.1), (0.75, 2.45), (0.33, 2.84)])
    assert clear["octagon"] > 0.9
    assert after([(0.05, 2.1), (0.45, 2.45), (0.86, 2.81)])["point_down"] > 0.9
    assert after([(0.6, 2.1), (0.6, 2.45), (0.6, 2.8)])["plate"] > 0.9
    assert after([(0.75, 2.45)])["octagon"] < 0.5


def test_chords_of_no_outline_are_unknown() -> None:
    ragged = after([(0.9, 2.1), (0.2, 2.3), (1.1, 2.5), (0.25, 2.8)])
    assert ragged["unknown"] == max(ragged.values())
