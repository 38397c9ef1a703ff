"""The road users of a scenario file, as actors of the simulator."""

import math

import numpy as np

from campusloop.scenes.scenario_files.road_users import Cue, Door, Follower, Group, Person, Queue, Vehicle
from campusloop.scenes.scenario_files.scenario_file import ScenarioFile
from contract.geometry import Array
from simulator.traffic.actors import Actors
from simulator.traffic.crowd import RADIUS_M
from simulator.traffic.dense import door_crowd
from simulator.traffic.dense.followers import FollowerRole, Followers
from simulator.traffic.scripted import ActorGroups, ScriptedRole, ScriptedTraffic
from simulator.traffic.social_crowd import CrowdParams, SocialCrowd
from vehicle_agent.signals import CYCLIST, PEDESTRIAN, VEHICLE

_BICYCLE_SIZE_M, _SCOOTER_SIZE_M = (1.8, 0.6), (1.2, 0.5)
_PERSON_SIZE_M = (2.0 * RADIUS_M, 2.0 * RADIUS_M)
_WALKS_MPS2 = 3.0
# How fast people of a queue walk to where they board.
_BOARDS_MPS = 1.0


def actors_of(found: ScenarioFile, points: Array) -> ActorGroups:
    """All road users of the file; points (n, 2): the shuttle's road, which a crowd is about."""
    roles = [_person(one) for one in found.person]
    roles += [_vehicle(one) for one in found.vehicle]
    roles += [role for one in found.group for role in _group(one)]
    roles += [role for one in found.queue for role in _queue(one)]
    groups: list[Actors] = [ScriptedTraffic(tuple(roles))]
    if found.crowd is not None:
        params = CrowdParams(
            people_per_100m2=found.crowd.people_per_100m2,
            attentive_ratio=found.crowd.attentive_ratio,
            reach_m=found.crowd.reach_m,
        )
        groups.append(SocialCrowd(params, points, found.seed))
    if found.door:
        groups.append(door_crowd.DoorCrowd(tuple(_door(one) for one in found.door), found.seed))
    if found.follower:
        groups.append(Followers(tuple(_follower(one) for one in found.follower)))
    return ActorGroups(tuple(groups))


def _person(one: Person) -> ScriptedRole:
    size_m = (one.diameter_m, one.diameter_m)
    if one.cyclist or one.scooter:
        size_m = _SCOOTER_SIZE_M if one.scooter else _BICYCLE_SIZE_M
    return _role(
        CYCLIST if one.cyclist or one.scooter else PEDESTRIAN, one.at, one.heading_deg, one.way,
        one.speed_mps, one.when, size_m=size_m, stays=one.stays, halt_at=one.halts_at, halt_s=one.halts_s,
    )  # fmt: skip


def _vehicle(one: Vehicle) -> ScriptedRole:
    return _role(
        VEHICLE, one.at, one.heading_deg, one.way, one.speed_mps, one.when,
        size_m=(one.length_m, one.width_m), accel_mps2=one.accel_mps2, stays=one.stays,
    )  # fmt: skip


def _group(one: Group) -> list[ScriptedRole]:
    """The people on their circle, each looking at its middle."""
    roles = []
    for k in range(one.count):
        angle = 2.0 * math.pi * k / one.count
        dx, dy = one.radius_m * math.cos(angle), one.radius_m * math.sin(angle)
        way = tuple((x + dx, y + dy) for x, y in one.way)
        at = (one.at[0] + dx, one.at[1] + dy)
        roles.append(_role(PEDESTRIAN, at, math.degrees(angle) + 180.0, way, one.speed_mps, one.when))
    return roles


def _queue(one: Queue) -> list[ScriptedRole]:
    """The first stands at the head; each walks past it to where they board."""
    heading = math.radians(one.heading_deg)
    roles = []
    for k in range(one.count):
        back_m = k * one.spacing_m
        at = (one.at[0] + back_m * math.cos(heading), one.at[1] + back_m * math.sin(heading))
        way = () if one.boards_at is None else (one.at, one.boards_at)
        when = Cue(one.when.time_s, one.when.distance_m, one.when.after_s + k * one.every_s)
        looks_deg = one.heading_deg + 180.0
        roles.append(_role(PEDESTRIAN, at, looks_deg, way, _BOARDS_MPS, when, stays=one.boards_at is None))
    return roles


def _door(one: Door) -> door_crowd.Door:
    return door_crowd.Door(
        at=one.at,
        heading_rad=math.radians(one.heading_deg),
        width_m=one.width_m,
        people=one.people,
        people_per_s=one.people_per_s,
        goals=np.array(one.goals, dtype=np.float64),
        from_s=one.from_s,
        attentive_ratio=one.attentive_ratio,
    )


def _follower(one: Follower) -> FollowerRole:
    cue = one.when
    sizes_m = {"": _PERSON_SIZE_M, "bicycle": _BICYCLE_SIZE_M, "scooter": _SCOOTER_SIZE_M}
    return FollowerRole(
        one.at,
        (one.place, *one.then),
        one.speed_mps,
        cue.time_s,
        cue.distance_m,
        cue.after_s,
        one.for_s,
        one.each_s,
        CYCLIST if one.rides else PEDESTRIAN,
        sizes_m[one.rides],
    )


def _role(
    kind: int,
    at: tuple[float, float],
    heading_deg: float,
    way: tuple[tuple[float, float], ...],
    speed_mps: float,
    cue: Cue,
    *,
    size_m: tuple[float, float] = _PERSON_SIZE_M,
    accel_mps2: float = _WALKS_MPS2,
    stays: bool = True,
    halt_at: int | None = None,
    halt_s: float = 0.0,
) -> ScriptedRole:
    return ScriptedRole(
        kind=kind,
        pose_map=(*at, math.radians(heading_deg)),
        size_m=size_m,
        way=np.array(way, dtype=np.float64).reshape(-1, 2),
        speed_mps=speed_mps,
        accel_mps2=accel_mps2,
        from_s=cue.time_s,
        distance_m=cue.distance_m,
        after_s=cue.after_s,
        stays=stays,
        halt_at=halt_at,
        halt_s=halt_s,
    )
