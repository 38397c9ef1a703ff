"""Published instance files: the formats' traps, and what a broken file is told."""

import json
from pathlib import Path

import pytest

from campusloop.studies.instances.instance import InstanceBroken
from campusloop.studies.instances.load import load_instance

_ROWS = [
    "0  0.0  0.0  0  0  0 480",
    "1  1.0  2.0  3  1  0 480",
    "2 -1.0  2.0  3  2 10  25",
    "3  4.0  2.0  3 -1 60  75",
    "4 -4.0 -2.0  3 -2  0 480",
]
_END = "5  0.0  0.0  0  0  0 400"


def _file(folder: Path, *lines: str, name: str = "tiny.txt") -> Path:
    path = folder / name
    path.write_text("\n".join(lines) + "\n")
    return path


@pytest.mark.parametrize("n", [2, 4])
@pytest.mark.parametrize("end", [(), (_END,)])
def test_n_may_count_requests_or_nodes_and_the_depot_may_come_twice(
    tmp_path: Path, n: int, end: tuple[str, ...]
) -> None:
    instance = load_instance(_file(tmp_path, f"2 {n} 480 3 30", *_ROWS, *end))
    assert instance.pairs.tolist() == [[1, 3], [2, 4]]
    assert (instance.vehicles, instance.capacity, instance.duration_max, instance.ride_max) == (2, 3, 480, 30)
    assert instance.late[0] == (400 if end else 480)


@pytest.mark.parametrize(
    ("lines", "told"),
    [
        (["2 4 480 3 30", *_ROWS[:-1]], "rows do not fit"),
        (["2 4 480 3 30", *_ROWS[:2], *_ROWS[3:]], "line 4: node 3 stands where 2 should"),
        (["2 4 480 3 30", *_ROWS[:-1], "4 -4.0 -2.0 3 -1 0 480"], "do not carry the same load"),
        (["2 4 480 3 30", *_ROWS[:-1], "4 -4.0 -2.0 3 -2 480 0"], "window of node 4 ends before it begins"),
        (["2 4 480 3 30", *_ROWS[:-1], "4 -4.0 here 3 -2 0 480"], "line 6: expected numbers"),
        (["2 4 480 3 30", *_ROWS[:-1], "4 -4.0 nan 3 -2 0 480"], "line 6: a value is not finite"),
        (["2 4 480 3 30", *_ROWS[:-1], "4 -4.0 -2.0"], "line 6: 3 columns instead of 7"),
        (["0 4 480 3 30", *_ROWS], "at least one vehicle"),
        (["2 4 480 1 30", *_ROWS], "fits into no vehicle"),
        (["2 4 480 3"], "the first line has 4 numbers"),
        ([""], "the first line has 0 numbers"),
    ],
)
def test_a_broken_dial_a_ride_file_is_told_where(tmp_path: Path, lines: list[str], told: str) -> None:
    with pytest.raises(InstanceBroken, match=told):
        load_instance(_file(tmp_path, *lines))


_LI_LIM = ["3 200 1", "0 40 50 0 0 1236 0 0 0", "1 45 68 10 0 900 90 0 2", "2 45 70 -10 0 967 90 1 0"]


def test_li_and_lim_pairs_follow_the_columns(tmp_path: Path) -> None:
    instance = load_instance(_file(tmp_path, *_LI_LIM))
    assert instance.pairs.tolist() == [[1, 2]]
    assert instance.fewest_vehicles_first
    assert instance.service.tolist() == [0, 90, 90]


def test_a_partner_without_a_row_is_named(tmp_path: Path) -> None:
    with pytest.raises(InstanceBroken, match=r"line 3: node 1 belongs to node 2, which has no row"):
        load_instance(_file(tmp_path, *_LI_LIM[:-1]))


def _dynamic(**changes: object) -> str:
    request = {
        "id": 1,
        "pickup_location": {"x_coord": 1.0, "y_coord": 2.0},
        "delivery_location": {"x_coord": 4.0, "y_coord": 2.0},
        "pickup_lower_tw": 0,
        "pickup_upper_tw": 1440,
        "pickup_service_time": 3,
        "delivery_lower_tw": 60,
        "delivery_upper_tw": 75,
        "delivery_service_time": 3,
        "load": 1,
        "arrival_time": 20,
    }
    facts = {
        "number_of_vehicles": 2,
        "vehicle_capacity": 3,
        "max_ride_time": 30,
        "max_route_time": 480,
        "planing_horizon": 1440,
        "depot_location": {"x_coord": 0.0, "y_coord": 0.0},
    }
    return json.dumps({"static_info": facts, "requests": [{**request, **changes}]})


def test_dynamic_requests_say_when_they_are_revealed(tmp_path: Path) -> None:
    instance = load_instance(_file(tmp_path, _dynamic(), name="tiny.json"))
    assert instance.revealed is not None
    assert instance.revealed.tolist() == [20]
    assert instance.early.tolist() == [0, 0, 60]


@pytest.mark.parametrize("changes", [{"id": 2}, {"load": 0}, {"pickup_location": {}}])
def test_a_broken_dynamic_file_is_refused(tmp_path: Path, changes: dict[str, object]) -> None:
    with pytest.raises(InstanceBroken, match="tiny"):
        load_instance(_file(tmp_path, _dynamic(**changes), name="tiny.json"))
