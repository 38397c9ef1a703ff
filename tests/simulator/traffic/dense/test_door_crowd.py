"""People come out of doors at their rate, go their ways, and never appear in somebody or in a shuttle."""

import math

import numpy as np
import pytest

from simulator.traffic.dense.door_crowd import Door, DoorCrowd

DT_S = 0.02
FAR = np.array([[-100.0, 0.0, 0.0, 0.85, 3.5, 0.815, 0.0]])
AHEAD = np.zeros((1, 40, 2))
AHEAD[0, :, 0] = np.arange(40.0)
DOOR = Door((0.0, 10.0), -0.5 * math.pi, 2.0, 12, 2.0, np.array([[-6.0, 0.0], [6.0, 0.0]]), from_s=1.0)


def stepped(crowd: DoorCrowd, seconds: float, vehicles: np.ndarray = FAR) -> list[int]:
    """The number of people who were out, after each step."""
    out = []
    for _ in range(round(seconds / DT_S)):
        crowd.step(vehicles, np.zeros(1), AHEAD, DT_S)
        out.append(len(crowd.bodies().numbers))
    return out


def test_they_come_out_at_the_rate_and_are_gone_at_their_goals() -> None:
    crowd = DoorCrowd((DOOR,), 1)
    assert max(stepped(crowd, 0.9)) == 0
    early = stepped(crowd, 3.1)
    assert 4 <= early[-1] <= 8
    stepped(crowd, 40.0)
    assert len(crowd.bodies().numbers) == 0


def test_a_seed_repeats_them_and_numbers_stay() -> None:
    one, two, other = DoorCrowd((DOOR,), 1), DoorCrowd((DOOR,), 1), DoorCrowd((DOOR,), 2)
    for crowd in (one, two, other):
        stepped(crowd, 6.0)
    assert one.bodies().poses_map.tolist() == two.bodies().poses_map.tolist()
    assert one.bodies().poses_map.tolist() != other.bodies().poses_map.tolist()
    before = dict(zip(one.bodies().numbers.tolist(), one.bodies().poses_map[:, :2], strict=True))
    stepped(one, DT_S)
    after = dict(zip(one.bodies().numbers.tolist(), one.bodies().poses_map[:, :2], strict=True))
    for number in before.keys() & after.keys():
        assert np.hypot(*(before[number] - after[number])) < 0.1


def test_nobody_comes_out_into_a_shuttle_that_stands_at_the_door() -> None:
    there = np.array([[-1.5, 10.0, 0.0, 0.85, 3.5, 0.815, 0.0]])
    crowd = DoorCrowd((DOOR,), 1)
    assert max(stepped(crowd, 6.0, there)) == 0
    assert stepped(crowd, 3.0)[-1] > 0


def test_held_they_are_hidden_and_time_stands_still() -> None:
    crowd = DoorCrowd((DOOR,), 1)
    crowd.hold = True
    assert max(stepped(crowd, 10.0)) == 0
    crowd.hold = False
    assert stepped(crowd, 0.5)[-1] == 0


@pytest.mark.parametrize("ratio", [0.0, 1.0])
def test_attention_is_that_of_the_door(ratio: float) -> None:
    door = Door((0.0, 10.0), 0.0, 2.0, 20, 5.0, np.array([[30.0, 10.0]]), attentive_ratio=ratio)
    crowd = DoorCrowd((door,), 1)
    stepped(crowd, 3.0)
    assert len(crowd.attentive) > 5
    assert set(crowd.attentive.tolist()) == {round(ratio)}
