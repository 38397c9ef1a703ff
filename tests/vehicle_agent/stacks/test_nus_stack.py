"""The NUS stack's whole tick on the simulated golf cart: rides over servo CAN, crossings, fleet mates."""

import dataclasses
import functools
import sys
from pathlib import Path

import msgspec
import numpy as np
import pytest
from numba.core.registry import CPUDispatcher

from contract.geometry import Pose2
from contract.roads.load import with_version
from contract.roads.model import ObservationArea, RoadMap
from contract.runlog.arrays import enc_hook
from contract.wire.messages import RiderAlighted, RiderBoarded, VisitChanged
from simulator.riders import Rider
from simulator.traffic.population import TrafficParams
from simulator.world import WorldOptions
from tests.vehicle_agent.driven_shuttle import DrivenShuttle, rider
from tests.vehicle_agent.mission.ring import ring
from vehicle_agent.config import Profile, load_profile
from vehicle_agent.onboard.car import Car
from vehicle_agent.planning.cost_map.crossings import CrossingRule
from vehicle_agent.runtime.recording.snapshot import decode_state, encode_state
from vehicle_agent.signals import FleetVehicle, PedestrianPresence
from vehicle_agent.stacks import warm
from vehicle_agent.stacks.nus import planning

_encoder = msgspec.msgpack.Encoder(enc_hook=enc_hook)
PROFILES = Path(__file__).resolve().parents[3] / "vehicle_agent" / "profiles"
START, ON, OFF = ("south", 5.0), ("south", 60.0), ("north", 30.0)
ZEBRA = ObservationArea(
    "zebra", "crossing", ((33.0, -3.5), (37.0, -3.5), (37.0, 3.5), (33.0, 3.5)), (("south", 32.5),)
)


@functools.cache
def the_ring() -> RoadMap:
    return with_version(msgspec.structs.replace(ring(), observation_areas=(ZEBRA,)))


def the_cart() -> Profile:
    return load_profile(PROFILES / "nus-cart.toml")


def a_cart(crossings: CrossingRule | None = None, traffic: TrafficParams | None = None) -> DrivenShuttle:
    profile = the_cart()
    shuttle = DrivenShuttle(the_ring(), START, profile, WorldOptions(traffic=traffic))
    if crossings is not None:
        shuttle.car = replaced_planning(shuttle, crossings)
    visits = (
        shuttle.visit("on", *ON, START, board=(rider("ann", 1, "1111"),), dwell_s=8.0),
        shuttle.visit("off", *OFF, ON, alight=(rider("ann", 1, "1111"),), dwell_s=8.0),
        shuttle.visit("rest", "north", 70.0, OFF, kind="rest", dwell_s=0.0),
    )
    shuttle.say(shuttle.order_for(visits, START))
    shuttle.run(1.0)
    shuttle.resume()
    return shuttle


def replaced_planning(shuttle: DrivenShuttle, crossings: CrossingRule) -> Car:
    return dataclasses.replace(shuttle.car, planning=planning(the_cart(), the_ring(), crossings))


def x_m(shuttle: DrivenShuttle) -> float:
    return shuttle.world.truth("s1").pose_map.x_m


def speed_mps(shuttle: DrivenShuttle) -> float:
    return shuttle.world.truth("s1").speed_mps


def bumper_m(shuttle: DrivenShuttle) -> float:
    return x_m(shuttle) + the_cart().body.front_overhang_m


def test_warm_kernels_leave_nothing_to_compile_for_a_drive() -> None:
    # First in this file: later on, other tests have compiled what warming may have forgotten.
    warm.warm_kernels()
    before = specialisations()
    told(a_cart(), 12.0, 1)
    grown = {name for name, count in specialisations().items() if count > before.get(name, 0)}
    assert grown == set()


def specialisations() -> dict[str, int]:
    found: dict[str, int] = {}
    for name, module in sorted(sys.modules.items()):
        if name.startswith(("vehicle_agent", "contract")) and module is not None:
            for attribute, value in sorted(vars(module).items()):
                if isinstance(value, CPUDispatcher):
                    found[f"{name}.{attribute}"] = len(value.signatures)
    return found


@pytest.mark.long
def test_a_ride_is_driven_from_stop_to_stop_within_twenty_centimetres() -> None:
    shuttle = a_cart()
    stops = [Pose2(*shuttle.network.pose(*place)) for place in (ON, OFF)]
    shuttle.world.riders.add(Rider("ann", "1111", 1, "code", stops[0], stops[1]))
    errors, asides, known = [], [], 0
    finished = False
    for _ in range(260 * 50):
        shuttle.step()
        if shuttle.outputs is not None:
            asides.append(abs(shuttle.outputs.flow.task.d_m))
        for _, event in shuttle.events[known:]:
            if isinstance(event, VisitChanged) and event.state == "under_way":
                state = shuttle.state.mission
                errors.append(abs(state.s_m - state.route.visit_s(event.visit_id)))
        known = len(shuttle.events)
        finished = not shuttle.state.mission.memory.open_visits()
        if finished:
            break
    assert finished
    events = [event for _, event in shuttle.events]
    assert RiderBoarded("ann", "code") in events
    assert any(isinstance(event, RiderAlighted) for event in events)
    assert max(errors) < 0.2
    assert max(asides) < 0.25
    score = shuttle.world.score("s1")
    assert 1.8 < score.speed_mps_max < 2.2
    assert score.hardest_braking_mps2 < 1.5
    assert shuttle.outputs is not None
    assert shuttle.outputs.report.faults == ()


def test_a_state_saved_mid_way_and_restored_gives_identical_outputs() -> None:
    kept, restored = a_cart(), a_cart()
    for k in range(20 * 50):
        assert _encoder.encode(kept.step()) == _encoder.encode(restored.step())
        if k % 250 == 100:
            restored.state = decode_state(encode_state(restored.state), restored.car)
    assert kept.world.truth("s1") == restored.world.truth("s1")


def test_the_cart_stops_behind_a_fleet_mate() -> None:
    shuttle = a_cart()
    for _ in range(30 * 50):
        shuttle.say(FleetVehicle(shuttle.now_ns, "mate", Pose2(30.0, 0.0, 0.0), 0.0))
        shuttle.step()
    gap_m = 30.0 - the_cart().body.rear_overhang_m - bumper_m(shuttle)
    assert speed_mps(shuttle) < 0.1
    assert 4.0 < gap_m < 7.0


def test_whoever_stands_in_the_way_is_stopped_for_and_not_touched() -> None:
    shuttle = a_cart(traffic=TrafficParams())
    assert shuttle.world.pedestrians is not None
    shuttle.run(240, lambda s: not s.state.mission.memory.open_visits())
    score = shuttle.world.score("s1")
    assert score.contacts == 0
    assert x_m(shuttle) != START[1]


def told(shuttle: DrivenShuttle, seconds: float, count: int) -> list[float]:
    """Speeds while the camera says this five times a second."""
    speeds = []
    for k in range(round(seconds * 50)):
        if k % 10 == 0:
            shuttle.say(PedestrianPresence(shuttle.now_ns, "zebra", count))
        shuttle.step()
        if 32.5 < bumper_m(shuttle) < 36.0:
            speeds.append(speed_mps(shuttle))
    return speeds


@pytest.mark.long
def test_an_occupied_crossing_is_passed_slowly_and_a_free_one_is_not() -> None:
    occupied = told(a_cart(), 35.0, 2)
    free = told(a_cart(), 35.0, 0)
    assert occupied
    assert free
    assert max(occupied) < 1.0
    assert min(free) > 1.5


@pytest.mark.long
def test_a_word_of_a_free_crossing_changes_nothing_for_who_never_stops() -> None:
    silent, word = a_cart(), a_cart()
    for k in range(25 * 50):
        if k % 10 == 0:
            word.say(PedestrianPresence(word.now_ns, "zebra", 0))
        silent.step()
        word.step()
    assert silent.world.truth("s1") == word.world.truth("s1")


def passes(crossings: CrossingRule, count: int | None, seconds: float = 40.0) -> tuple[float, float]:
    """(least speed in the 3 m before the stop line, bumper at the end)."""
    shuttle = a_cart(crossings)
    slowest = np.inf
    for k in range(round(seconds * 50)):
        if count is not None and k % 10 == 0:
            shuttle.say(PedestrianPresence(shuttle.now_ns, "zebra", count))
        shuttle.step()
        if 29.5 < bumper_m(shuttle) < 32.6:
            slowest = min(slowest, speed_mps(shuttle))
    return slowest, bumper_m(shuttle)


@pytest.mark.long
def test_the_baseline_stops_before_every_crossing_and_goes_on_when_it_is_seen_free() -> None:
    slowest, end_m = passes(CrossingRule("always"), 0)
    assert slowest < 0.1
    assert end_m > 40.0


def test_a_fresh_word_spares_the_stop_where_the_cart_sees_it_free_too() -> None:
    slowest, end_m = passes(CrossingRule("untold"), 0)
    assert slowest > 1.2
    assert end_m > 40.0


@pytest.mark.parametrize("count", [pytest.param(None, marks=pytest.mark.long), 1])
def test_without_the_word_or_with_people_there_the_stop_is_made(count: int | None) -> None:
    slowest, _ = passes(CrossingRule("untold"), count)
    assert slowest < 0.1


@pytest.mark.long
def test_a_stop_is_not_spared_for_a_crossing_that_the_cart_cannot_see() -> None:
    slowest, _ = passes(CrossingRule("untold", known_min=1.01), 0, 30.0)
    assert slowest < 0.1
