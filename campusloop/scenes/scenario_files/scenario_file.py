"""The format of scenario files: one TOML file for each scenario (docs/simulator/scenarios.md).

Errors name the file and the field.
"""

import math
from pathlib import Path
from typing import Annotated, Literal

import msgspec
from msgspec import Meta

from campusloop.scenes.faults import Camera, InputFault
from campusloop.scenes.scenario_files.road_users import (
    Crowd,
    Door,
    Follower,
    Group,
    NotNegative,
    OtherShuttle,
    Person,
    Place,
    Positive,
    Queue,
    Table,
    Vehicle,
)
from contract.roads.model import Scenario


class ScenarioError(Exception):
    """A scenario file cannot be driven; the message names file and field."""


class Crossing(Table, frozen=True):
    """An observation area across the path, between s_m and s_m + length_m, reach_m to each side."""

    id: str
    s_m: NotNegative
    length_m: Positive = 4.0
    reach_m: Positive = 6.0
    kind: Literal["crossing", "intersection"] = "crossing"


class Road(Table, frozen=True):
    """Either `path` (points of the rear axle's path, m) or `map` with two of its stops."""

    path: tuple[Place, ...] = ()
    width_m: Positive = 4.0
    speed_limit_mps: Positive = 4.2
    scenario: Scenario = "common_road"
    area: tuple[Crossing, ...] = ()
    map: str = ""
    from_stop: str = ""
    to_stop: str = ""


class Shuttle(Table, frozen=True):
    """start_s_m, goal_s_m: along the road; default goal: 6 m before its end. speed_mps_max 0: no cap."""

    start_s_m: NotNegative = 6.0
    start_mps: NotNegative = 0.0
    goal_s_m: Positive | None = None
    speed_mps_max: NotNegative = 0.0


class Occluder(Table, frozen=True):
    """A wall or a hut that occludes what is behind it."""

    at: Place
    length_m: Positive
    width_m: Positive
    heading_deg: float = 0.0
    height_m: Positive = 3.0


class Noise(Table, frozen=True):
    """Of the tracker. dropout_ratio: of scans in which a visible object is missed."""

    dropout_ratio: Annotated[float, Meta(ge=0.0, lt=1.0)] = 0.03
    latency_s: NotNegative = 0.08


class Operator(Table, frozen=True):
    """resume_s: when an operator resumes the vehicle."""

    resume_s: tuple[NotNegative, ...] = ()


class Expectations(Table, frozen=True):
    """What the run must fulfil; missing fields are not checked.

    contacts           front contacts of all shuttles, at most
    reaches_goal       within the scenario's max_time_s
    time_s_max         to the goal
    clearance_m_min    to every person and vehicle while the vehicle moved
    stops_before_s_m   the rear axle stood for half a second before it first passed this position
    never_passes_s_m   the rear axle never passed this position
    stands_s_min       total time of standing after the vehicle has moved
    decel_mps2_max     the hardest braking (mean over 0.1 s)
    stands_until_s     the vehicle has not moved before this time
    others_arrive      the other shuttles come to the ends of their roads
    says               texts among the reported modes, fault codes and limits
    never_says         texts that must not be among them
    """

    contacts: Annotated[int, Meta(ge=0)] = 0
    reaches_goal: bool | None = None
    time_s_max: Positive | None = None
    clearance_m_min: float | None = None
    stops_before_s_m: Positive | None = None
    never_passes_s_m: Positive | None = None
    stands_s_min: Positive | None = None
    decel_mps2_max: Positive | None = None
    stands_until_s: Positive | None = None
    others_arrive: bool | None = None
    says: tuple[str, ...] = ()
    never_says: tuple[str, ...] = ()


class ScenarioFile(Table, frozen=True):
    """One scenario. stacks: the stacks to which it applies; empty: all."""

    title: str
    road: Road
    max_time_s: Positive = 60.0
    seed: int = 1
    stacks: tuple[str, ...] = ()
    shuttle: Shuttle = Shuttle()
    person: tuple[Person, ...] = ()
    vehicle: tuple[Vehicle, ...] = ()
    occluder: tuple[Occluder, ...] = ()
    group: tuple[Group, ...] = ()
    queue: tuple[Queue, ...] = ()
    door: tuple[Door, ...] = ()
    follower: tuple[Follower, ...] = ()
    other_shuttle: tuple[OtherShuttle, ...] = ()
    crowd: Crowd | None = None
    noise: Noise = Noise()
    camera: tuple[Camera, ...] = ()
    fault: tuple[InputFault, ...] = ()
    operator: Operator = Operator()
    expect: Expectations = Expectations()


def load_scenario(path: Path) -> ScenarioFile:
    """Raises ScenarioError with file and field."""
    try:
        found = msgspec.toml.decode(path.read_bytes(), type=ScenarioFile)
    except OSError as error:
        raise ScenarioError(f"{path}: {error.strerror}") from error
    except msgspec.DecodeError as error:
        raise ScenarioError(f"{path}: {error}") from error
    for field, wrong in _wrong(found):
        raise ScenarioError(f"{path}: {wrong} - at `$.{field}`")
    return found


def _wrong(found: ScenarioFile) -> list[tuple[str, str]]:
    """(field, what is wrong) beyond the types."""
    wrong, road = [], found.road
    if bool(road.path) == bool(road.map):
        wrong.append(("road", "give either `path`, or `map` with `from_stop` and `to_stop`"))
    if road.map and not (road.from_stop and road.to_stop):
        wrong.append(("road", "a map needs `from_stop` and `to_stop`"))
    if road.path and len(road.path) < 2:
        wrong.append(("road.path", "a path needs at least two places"))
    if road.map and road.area:
        wrong.append(("road.area", "a map has observation areas of its own"))
    goal_s_m = found.shuttle.goal_s_m
    if goal_s_m is not None and goal_s_m <= found.shuttle.start_s_m:
        wrong.append(("shuttle.goal_s_m", "the goal must lie beyond start_s_m"))
    for k, fault in enumerate(found.fault):
        if fault.to_s <= fault.from_s:
            wrong.append((f"fault[{k}].to_s", "to_s must be later than from_s"))
    for k, camera in enumerate(found.camera):
        if not camera.rate_hz > 0.0:
            wrong.append((f"camera[{k}].rate_hz", "the rate must be more than 0 Hz"))
    for k, person in enumerate(found.person):
        if person.cyclist and person.scooter:
            wrong.append((f"person[{k}].scooter", "somebody rides a bicycle or a scooter, not both"))
        if person.halts_at is not None and person.halts_at >= len(person.way):
            wrong.append((f"person[{k}].halts_at", f"`way` has only {len(person.way)} places"))
    for k, door in enumerate(found.door):
        if not door.goals:
            wrong.append((f"door[{k}].goals", "give at least one place to go to"))
    for k, other in enumerate(found.other_shuttle):
        if len(other.path) < 2:
            wrong.append((f"other_shuttle[{k}].path", "a path needs at least two places"))
    if found.expect.others_arrive is not None and not found.other_shuttle:
        wrong.append(("expect.others_arrive", "there is no `[[other_shuttle]]`"))
    for name, places in _places(found):
        if not all(math.isfinite(value) for place in places for value in place):
            wrong.append((name, "a coordinate is not finite"))
    return wrong


def _places(found: ScenarioFile) -> list[tuple[str, tuple[Place, ...]]]:
    out: list[tuple[str, tuple[Place, ...]]] = [("road.path", found.road.path)]
    out += [(f"person[{k}]", (one.at, *one.way)) for k, one in enumerate(found.person)]
    out += [(f"vehicle[{k}]", (one.at, *one.way)) for k, one in enumerate(found.vehicle)]
    out += [(f"occluder[{k}]", (one.at,)) for k, one in enumerate(found.occluder)]
    out += [(f"group[{k}]", (one.at, *one.way)) for k, one in enumerate(found.group)]
    out += [
        (f"queue[{k}]", (one.at, one.boards_at) if one.boards_at else (one.at,))
        for k, one in enumerate(found.queue)
    ]
    out += [(f"door[{k}]", (one.at, *one.goals)) for k, one in enumerate(found.door)]
    out += [(f"follower[{k}]", (one.at, one.place, *one.then)) for k, one in enumerate(found.follower)]
    out += [(f"other_shuttle[{k}].path", one.path) for k, one in enumerate(found.other_shuttle)]
    return out
