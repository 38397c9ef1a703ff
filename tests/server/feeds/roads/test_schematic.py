"""The Snow Lion map against Table 1."""

import math
from itertools import pairwise

import numpy as np
import pytest

from contract.roads.load import load_map
from contract.roads.network import RoadNetwork
from contract.roads.routing import find_route
from server.feeds.roads.schematic import snow_lion_map
from tests.server.feeds.roads.shipped import SNOW_LION_MAP

ROAD_MAP = snow_lion_map()
NETWORK = RoadNetwork(ROAD_MAP)


def test_the_shipped_file_is_what_the_program_builds() -> None:
    assert load_map(SNOW_LION_MAP).map_version == ROAD_MAP.map_version
    assert ROAD_MAP.schematic


def test_the_stations_lie_apart_by_table_1s_gaps_less_the_dwell() -> None:
    gaps_s = (180, 420, 720, 180, 60, 420)
    assert [stop.stop_id for stop in ROAD_MAP.stops] == ["NN7", "NN20", "C6", "SE13", "GYM", "1B", "C1"]
    for (one, other), gap_s in zip(pairwise(ROAD_MAP.stops), gaps_s, strict=True):
        route = find_route(NETWORK, one.lane_id, one.s_m, other.lane_id, other.s_m)
        assert route is not None
        assert route.length_m == pytest.approx((gap_s - 20) * 7.41 / 3.6, abs=0.5)


MORNING = {
    "morning-1": ["08:00", "08:03", "08:10"],
    "morning-2": ["08:20", "08:23", "08:30"],
    "morning-3": ["08:40", "08:43", "08:50", "09:02", "09:05", "09:06", "09:13"],
    "morning-4": ["09:25", "09:28", "09:29", "09:36"],
    "morning-5": ["09:48", "09:51", "09:52", "10:00"],
}


def clocks(shift: str) -> dict[str, list[str]]:
    return {
        trip.trip_id: [f"{t // 3600:02d}:{t % 3600 // 60:02d}" for _, t in trip.calls]
        for trip in ROAD_MAP.timetable
        if trip.trip_id.startswith(shift)
    }


def test_the_timetable_is_table_1() -> None:
    assert clocks("morning") == MORNING


def test_noon_is_the_morning_four_hours_later_and_the_evening_ends_at_seven() -> None:
    noon, evening = clocks("noon"), clocks("evening")
    assert (len(noon), noon["noon-1"][0], noon["noon-5"][-1]) == (5, "12:00", "14:00")
    assert (len(evening), evening["evening-1"][0], evening["evening-3"][-1]) == (3, "17:30", "18:43")
    assert {trip.service_id for trip in ROAD_MAP.timetable} == {"daily"}


@pytest.mark.parametrize(("last", "first", "time_s"), [("C6", "NN7", 600), ("C1", "SE13", 720)])
def test_the_shuttle_is_back_in_time_for_its_next_trip(last: str, first: str, time_s: int) -> None:
    one, other = NETWORK.stops[last], NETWORK.stops[first]
    clear = NETWORK.kept_clear(())
    route = find_route(
        NETWORK, one.lane_id, one.s_m, other.lane_id, other.s_m, clear, speed_cap_mps=11.76 / 3.6
    )
    assert route is not None
    assert route.time_s < time_s - 20


def test_every_road_is_wide_enough_to_pass_and_there_is_room_to_rest() -> None:
    assert all(lane.can_pass for lane in ROAD_MAP.lanes if lane.kind == "road")
    assert len(ROAD_MAP.resting_places) >= 4


def test_the_meander_does_not_meet_itself() -> None:
    line = np.vstack([np.array(lane.points) for lane in ROAD_MAP.lanes if lane.lane_id.startswith("east-")])[
        ::4
    ]
    for i, here in enumerate(line):
        far = np.abs(np.arange(len(line)) - i) > 60
        assert math.sqrt(((line[far] - here) ** 2).sum(axis=1).min()) > 50.0
