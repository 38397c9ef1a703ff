from pathlib import Path

import pytest
from rich.console import Console

from campusloop.virtual.campus import CampusOptions
from campusloop.virtual.headless import run_headless
from contract.roads.load import load_map
from tests.faults.real_campus import nearest_pair
from tests.scenarios.campus_days import CampusDay
from tests.server.feeds.roads.shipped import CAMPUS_MAP
from vehicle_agent.runtime.replay import replay_segment
from vehicle_agent.stacks.choice import build_car


@pytest.mark.long
def test_two_rides_are_booked_driven_through_people_and_replayed(tmp_path: Path) -> None:
    console, road_map = Console(quiet=True), load_map(CAMPUS_MAP)
    options = CampusOptions(road_map, tmp_path, seed=1, vehicles=2)
    result = run_headless(options, 2, console, [nearest_pair(road_map)], spacing_s=5.0)
    assert result.failures == []
    assert [journey.state for journey in result.journeys] == ["completed", "completed"]
    for journey in result.journeys:
        assert [state for _, state in journey.history][-3:] == ["boarding", "aboard", "completed"]


def test_a_link_that_is_cut_while_riding_changes_nothing_for_the_passenger(day: CampusDay) -> None:
    journey = day.request_ride()
    day.until_state(journey, "aboard")
    day.campus.network.cut("shuttle-1")
    day.run_for(20.0)
    day.campus.network.restore("shuttle-1")
    day.until_state(journey, "completed")
    assert [state for number, state in day.states].count("aboard") == 1


@pytest.mark.long
def test_a_server_that_restarts_while_riding_loses_no_ride(day: CampusDay) -> None:
    journey = day.request_ride()
    day.until_state(journey, "aboard")
    day.campus.stop_server()
    day.campus.start_server()
    day.until_state(journey, "completed")


@pytest.mark.long
def test_a_vehicle_that_crashes_while_riding_stands_held_until_an_operator_resumes_it(
    day: CampusDay, tmp_path: Path
) -> None:
    journey = day.request_ride()
    day.until_state(journey, "aboard")
    day.run_for(5.0)
    vehicle = day.campus.vehicles["shuttle-1"]
    vehicle.crash()
    day.run_for(2.0)
    vehicle.boot(day.campus.conductor.now_ns)
    day.run_for(30.0)
    assert journey.state == "aboard"
    assert abs(day.campus.world.truth("shuttle-1").speed_mps) < 0.01
    day.campus.call(day.campus.operator.release("shuttle-1"))
    day.until_state(journey, "completed")
    assert [state for number, state in day.states].count("completed") == 1
    day.close()
    for segment in sorted((tmp_path / "shuttle-1" / "runs").rglob("*.mcap")):
        assert replay_segment(segment, build_car).difference is None
