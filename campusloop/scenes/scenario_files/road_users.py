"""The tables of a scenario file that put road users into a scene (docs/simulator/scenarios.md)."""

from typing import Annotated, Literal

import msgspec
from msgspec import Meta

Place = tuple[float, float]
Positive = Annotated[float, Meta(gt=0.0)]
NotNegative = Annotated[float, Meta(ge=0.0)]
Ratio = Annotated[float, Meta(ge=0.0, le=1.0)]


class Table(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A table whose unknown fields are errors."""


class Cue(Table, frozen=True):
    """When a person or vehicle starts: at a time, at a distance, or when both are reached.

    after_s: delay from then on
    """

    time_s: NotNegative | None = None
    distance_m: Positive | None = None
    after_s: NotNegative = 0.0


class Person(Table, frozen=True):
    """Stands at `at` with heading_deg, then walks or rides along the places of `way`.

    halts_at  number of the place of `way`, from 0, where the person stops dead, for halts_s
    """

    at: Place
    heading_deg: float = 0.0
    way: tuple[Place, ...] = ()
    speed_mps: Positive = 1.3
    diameter_m: Positive = 0.5
    cyclist: bool = False
    scooter: bool = False
    when: Cue = Cue()
    stays: bool = True
    halts_at: Annotated[int, Meta(ge=0)] | None = None
    halts_s: NotNegative = 20.0


class Vehicle(Table, frozen=True):
    """Parked, or driving along `way`."""

    at: Place
    heading_deg: float = 0.0
    way: tuple[Place, ...] = ()
    speed_mps: Positive = 4.0
    accel_mps2: Positive = 1.0
    length_m: Positive = 4.5
    width_m: Positive = 1.8
    when: Cue = Cue()
    stays: bool = True


class Crowd(Table, frozen=True):
    """People who react: see `simulator.traffic.social_crowd`."""

    people_per_100m2: NotNegative
    attentive_ratio: Annotated[float, Meta(ge=0.0, le=1.0)] = 0.8
    reach_m: Positive = 12.0


class Group(Table, frozen=True):
    """People who stand in a circle and talk. From the cue on they walk along `way`, in the same circle."""

    at: Place
    count: Annotated[int, Meta(ge=2, le=30)]
    radius_m: Positive = 0.8
    way: tuple[Place, ...] = ()
    speed_mps: Positive = 1.2
    when: Cue = Cue()


class Queue(Table, frozen=True):
    """People who stand in a line from `at` in the direction heading_deg.

    boards_at  where they go from the cue on, one every every_s; they are gone there. None: they stand on
    """

    at: Place
    count: Annotated[int, Meta(ge=1, le=60)]
    heading_deg: float = 0.0
    spacing_m: Positive = 0.7
    boards_at: Place | None = None
    every_s: Positive = 2.0
    when: Cue = Cue()


class Door(Table, frozen=True):
    """A door that people come out of, to any of `goals`; see `simulator.traffic.dense.door_crowd`."""

    at: Place
    goals: tuple[Place, ...]
    people: Annotated[int, Meta(ge=1, le=300)]
    heading_deg: float = 0.0
    width_m: Positive = 2.0
    people_per_s: Annotated[float, Meta(gt=0.0, le=10.0)] = 1.0
    from_s: NotNegative = 0.0
    attentive_ratio: Ratio = 0.8


class Follower(Table, frozen=True):
    """Somebody who keeps to `place` about the shuttle, for_s from the cue on, and then goes off to the side.

    place  in the shuttle's frame: m ahead of the rear axle, m to the left
    then   the next places, each after each_s at the one before
    """

    at: Place
    place: Place
    speed_mps: Positive = 2.5
    then: tuple[Place, ...] = ()
    each_s: Positive = 5.0
    rides: Literal["", "bicycle", "scooter"] = ""
    for_s: Positive = 60.0
    when: Cue = Cue()


class OtherShuttle(Table, frozen=True):
    """Another shuttle of the same stack, which drives a road of its own to its end."""

    path: tuple[Place, ...]
    width_m: Positive = 4.0
    speed_limit_mps: Positive = 4.2
    start_s_m: NotNegative = 6.0
    start_mps: NotNegative = 0.0
