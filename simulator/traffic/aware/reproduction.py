"""How people of the model walk with a recorded car's motion in the shuttle's place."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from contract.geometry import Array, BoolArray
from simulator.traffic.aware.acceptance import accepted_limits, car_rows
from simulator.traffic.aware.desired import FREE_PERCENTILE, desired_way, near_s
from simulator.traffic.aware.params import ReactionParams
from simulator.traffic.aware.people import AwarePeople
from simulator.traffic.aware.reaction import PACE
from simulator.traffic.aware.ways import OwnWays, own_ways
from simulator.traffic.crowd import V_SPEED
from simulator.traffic.recordings import Clip, RecordedTrack

Outline = tuple[float, float, float]
_DT_S = 0.02
# Places are taken this often.
SAMPLE_STEPS = 5
SAMPLE_S = SAMPLE_STEPS * _DT_S


@dataclass(frozen=True, slots=True)
class Walk:
    """A simulated walk of n people at k times.

    times_s (k,); places, recorded (k, n, 2); present (k, n): who is in the scene and in the recording
    vehicle (k, 7): rows of `traffic.crowd`; paces (k, n): speeds over those of the own ways
    """

    times_s: Array
    places: Array
    recorded: Array
    present: BoolArray
    vehicle: Array
    paces: Array

    def displacements_m(self) -> Array:
        """All distances between where people of the model and recorded people were."""
        apart: Array = np.hypot(*(self.places - self.recorded)[self.present].T)
        return apart


def walk(
    people: Sequence[RecordedTrack],
    ways: OwnWays,
    limits: Array,
    params: ReactionParams,
    car: RecordedTrack,
    ends_s: float,
    outline: Outline | None,
    late_s: float = 0.0,
) -> Walk:
    """The walk of the people on these ways while the car drives.

    outline  rear, front and half width around the car's middle, None for a scene without it
    late_s   the vehicle does everything that much later than the car; before and after it stands
    """
    times = np.arange(car.times_s[0], car.times_s[-1] + 1e-9, _DT_S)
    rows = _vehicle(car, times - late_s)
    if outline is not None:
        rows[:, 3:6] = outline
    shown = 0 if outline is None else 1
    crowd = AwarePeople([p.number for p in people], ways, limits, params, float(times[0]), ends_s)
    places, present, paces = [], [], []
    for k in range(len(times)):
        if k:
            crowd.step(rows[k : k + shown], _DT_S)
        if k % SAMPLE_STEPS == 0:
            places.append(crowd.places.copy())
            present.append(crowd.present.copy())
            paces.append(crowd.state[:, PACE].copy())
    at_s = times[::SAMPLE_STEPS]
    there = np.array(present)
    recorded = np.empty((len(at_s), len(people), 2))
    for i, person in enumerate(people):
        for c in (0, 1):
            recorded[:, i, c] = np.interp(at_s, person.times_s, person.states[:, c])
        there[:, i] &= (at_s >= person.times_s[0] - 1e-6) & (at_s <= person.times_s[-1] + 1e-6)
    return Walk(at_s, np.array(places), recorded, there, rows[::SAMPLE_STEPS], np.array(paces))


def _vehicle(car: RecordedTrack, at_s: Array) -> Array:
    """(k, 7) rows of the car, standing before its first and after its last time."""
    first_s, last_s = float(car.times_s[0]), float(car.times_s[-1])
    rows, _ = car_rows(car, np.clip(at_s, first_s, last_s))
    rows[(at_s < first_s) | (at_s > last_s), V_SPEED] = 0.0
    return rows


@dataclass(frozen=True, slots=True)
class Reproduction:
    """Displacements from the recording in metres, every 0.1 s of everyone, with the car's own motion.

    deployed    the model as the shuttle meets it: own ways as recorded, own limits
    population  the same with everyone's fitted limits: what was learnt from the person is taken away
    recreated   on desired ways, without the car's influence, with fitted limits: people in the car's way only
    unheeding   the same people on desired ways, heeding nothing: what there is to explain
    """

    deployed_m: Array
    population_m: Array
    recreated_m: Array
    unheeding_m: Array


def reproduction(
    clip: Clip, car: RecordedTrack, outline: Outline, params: ReactionParams | None = None
) -> Reproduction:
    """The displacements for one recorded drive; the outline is the shuttle's, around the car's middle."""
    params = params or ReactionParams()
    people = [track for track in clip.tracks if not track.is_driven]
    ways = own_ways([(person.times_s, person.states) for person in people])
    own = walk(people, ways, accepted_limits(ways, clip.cars(), params), params, car, clip.ends_s, outline)
    fitted = walk(people, ways, params.limits(len(people)), params, car, clip.ends_s, outline)
    met = met_people(clip, car)
    return Reproduction(
        own.displacements_m(),
        fitted.displacements_m(),
        met.walk(params, outline).displacements_m(),
        met.walk(params, None).displacements_m(),
    )


@dataclass(frozen=True, slots=True)
class MetPeople:
    """People in a car's way, and their desired ways without its influence."""

    people: tuple[RecordedTrack, ...]
    ways: OwnWays
    car: RecordedTrack
    ends_s: float

    def walk(self, params: ReactionParams, outline: Outline | None) -> Walk:
        """Their walk with the fitted limits; outline as in `walk`."""
        limits = params.limits(len(self.people))
        return walk(self.people, self.ways, limits, params, self.car, self.ends_s, outline)


def met_people(clip: Clip, car: RecordedTrack, percentile: float = FREE_PERCENTILE) -> MetPeople:
    """The people of the clip in the car's way, at this percentile of their speeds as their free speed."""
    people = [track for track in clip.tracks if not track.is_driven]
    stays = [near_s(person, [car]) for person in people]
    met = [(person, stay) for person, stay in zip(people, stays, strict=True) if stay]
    ways = own_ways([desired_way(person, stay, percentile) for person, stay in met])
    return MetPeople(tuple(person for person, _ in met), ways, car, clip.ends_s)
