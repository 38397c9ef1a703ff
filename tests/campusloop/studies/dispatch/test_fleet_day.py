"""A day on the board alone: promises hold, the same day comes out again, and other fleets can be tried."""

from dataclasses import replace
from datetime import date
from pathlib import Path
from zoneinfo import ZoneInfo

import pytest
from typer.testing import CliRunner

from campusloop.cli import app_of
from contract.roads.load import encode_map
from contract.roads.network import RoadNetwork
from server.domain.rules import FleetRules
from server.travel.fleet_roads import FleetRoads
from server.usecases.planning.day_figures import DayFigures, figures_of
from server.usecases.planning.fleet_day import POLICIES, Shuttle, run_day
from simulator.demand.day import WantedRide, draw_day
from simulator.demand.profile import built_in_profile
from simulator.demand.table import write_rides
from tests.server.usecases.shipped_maps import shipped_map

RULES = FleetRules()
RUN = CliRunner()


@pytest.fixture(scope="module")
def roads() -> FleetRoads:
    return FleetRoads(RoadNetwork(shipped_map("snow-lion")), RULES.speed_cap_mps, RULES.travel_time_factor)


def some_rides(roads: FleetRoads, rides: int = 60) -> tuple[WantedRide, ...]:
    zone = ZoneInfo("Asia/Shanghai")
    return draw_day(built_in_profile(), roads.stop_ids, date(2026, 1, 8), zone, rides, seed=3)


def figures(roads: FleetRoads, rides: tuple[WantedRide, ...], shuttles: int, policy: str) -> DayFigures:
    fleet = [Shuttle(f"s{k}", 6, 1) for k in range(shuttles)]
    return figures_of(run_day(rides, fleet, roads, RULES, POLICIES[policy]))


@pytest.mark.parametrize("policy", list(POLICIES))
def test_every_promise_is_kept_and_every_ride_has_one_end(roads: FleetRoads, policy: str) -> None:
    rides = some_rides(roads)
    found = figures(roads, rides, 2, policy)
    assert found.asked == len(rides) == found.served + found.cancelled + found.refused
    assert found.promises_kept == found.served > 0
    assert found.cancelled > 0
    assert found.driving_h > 0.0
    assert found.ride_over_direct is not None
    assert found.ride_over_direct >= 1.0


def test_a_day_comes_out_the_same_again(roads: FleetRoads) -> None:
    rides = some_rides(roads)
    assert figures(roads, rides, 2, "improvement") == figures(roads, rides, 2, "improvement")


def test_with_many_shuttles_nobody_is_refused_for_time_and_waits_are_short(roads: FleetRoads) -> None:
    rides = tuple(replace(ride, cancelled_at=None, wheelchairs=0) for ride in some_rides(roads))
    few, many = figures(roads, rides, 1, "insertion"), figures(roads, rides, 12, "insertion")
    assert many.refused == 0 < few.refused
    assert many.wait_median_s is not None
    assert few.wait_median_s is not None
    assert many.wait_median_s < few.wait_median_s


def test_who_cancels_in_the_same_second_is_not_fetched(roads: FleetRoads) -> None:
    rides = tuple(replace(ride, cancelled_at=ride.announced_at) for ride in some_rides(roads, 10))
    found = figures(roads, rides, 3, "insertion")
    assert (found.served, found.cancelled) == (0, 10)
    assert found.in_vain <= 10


@pytest.fixture
def files(tmp_path: Path, roads: FleetRoads) -> tuple[str, str]:
    csv_path, map_path = tmp_path / "day.csv", tmp_path / "map.json"
    write_rides(csv_path, some_rides(roads, 20))
    map_path.write_bytes(encode_map(roads.network.road_map))
    return str(csv_path), str(map_path)


def what_if(*words: str) -> tuple[int, str]:
    done = RUN.invoke(app_of(["dispatch"]), ["dispatch", "what-if", *words])
    return done.exit_code, " ".join(done.output.split())


def test_the_command_prints_both_fleets_side_by_side(files: tuple[str, str]) -> None:
    csv_path, map_path = files
    code, output = what_if(
        csv_path, "--map", map_path, "--fleet", "2", "--vehicles", "+1", "--policy", "insertion"
    )
    assert code == 0, output
    assert "2 shuttles" in output
    assert "3 shuttles" in output
    assert "promises kept" in output


@pytest.mark.parametrize(
    ("more", "words"),
    [
        (("--policy", "magic"), "there is no policy magic; there is insertion"),
        (("--fleet", "0"), "a fleet of 0 shuttles serves no ride"),
        (("--vehicles", "-3"), "a fleet of 0 shuttles serves no ride"),
        (("--vehicles", "few"), "not a change of the fleet"),
    ],
)
def test_what_cannot_be_tried_ends_with_2_and_says_why(
    files: tuple[str, str], more: tuple[str, ...], words: str
) -> None:
    code, output = what_if(files[0], "--map", files[1], *more)
    assert code == 2
    assert words in output


def test_a_table_without_rides_or_of_another_map_ends_with_2(files: tuple[str, str], tmp_path: Path) -> None:
    empty, other = tmp_path / "empty.csv", tmp_path / "other.csv"
    empty.write_text("announced_at,from_stop,to_stop\n")
    other.write_text("announced_at,from_stop,to_stop\n2026-01-08T19:00:00Z,HERE,THERE\n")
    for path, words in ((empty, "nothing to try"), (other, "HERE, a stop that the map does not have")):
        code, output = what_if(str(path), "--map", files[1])
        assert (code, words in output) == (2, True), output
    assert what_if(files[0])[0] == 2
