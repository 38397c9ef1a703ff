"""The older turn is moved by the vehicle's own motion: what stands still stays where it is."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from contract.geometry import Pose2, compose, inverse
from vehicle_agent.perception.pillars.sweeps import Sweep, step

POSES = st.builds(Pose2, st.floats(-50.0, 50.0), st.floats(-50.0, 50.0), st.floats(-3.1, 3.1))


def seen_from(pose: Pose2, stamp_ns: int, posts: np.ndarray) -> Sweep:
    """Posts (n, 2) of the odometry's frame as a vehicle at the pose sees them."""
    back = inverse(pose)
    places = [compose(back, Pose2(x, y, 0.0)) for x, y in posts]
    points = np.array([(place.x_m, place.y_m, 0.7) for place in places], dtype=np.float32)
    return Sweep(stamp_ns, pose, points, np.full(len(posts), 30.0, dtype=np.float32))


@given(first=POSES, second=POSES)
def test_what_stands_still_is_at_the_same_place_in_both_turns(first: Pose2, second: Pose2) -> None:
    posts = np.array([[3.0, 4.0], [-10.0, 2.0]])
    _, memory = step((), seen_from(first, 1_000_000_000, posts))
    newest = seen_from(second, 1_200_000_000, posts)
    older, _ = step(memory, newest)
    assert older is not None
    assert older.points_base == pytest.approx(newest.points_base, abs=1e-3)


def test_of_turns_every_100_ms_the_last_but_one_is_taken() -> None:
    memory: tuple[Sweep, ...] = ()
    for number in range(6):
        sweep = Sweep(
            100_000_000 * number, Pose2(0.0, 0.0, 0.0), np.full((1, 3), float(number), dtype=np.float32),
            np.zeros(1, dtype=np.float32),
        )  # fmt: skip
        older, memory = step(memory, sweep)
        assert (older is None) == (number < 2)
        if older is not None:
            assert older.points_base[0, 2] == number - 2
    assert len(memory) <= 4


def test_after_a_gap_and_after_a_restart_there_is_no_older_turn() -> None:
    posts = np.array([[3.0, 4.0]])
    here = Pose2(0.0, 0.0, 0.0)
    _, memory = step((), seen_from(here, 1_000_000_000, posts))
    older, memory = step(memory, seen_from(here, 3_000_000_000, posts))
    assert older is None
    older, memory = step(memory, seen_from(here, 1_200_000_000, posts))
    assert older is None
    assert len(memory) == 1
