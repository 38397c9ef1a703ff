"""Cyclists and scooters that overtake the vehicle and get in its way."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from campusloop.scenes.protection.cell import BEFORE_S, KMH, SCOOTER_SIZE_M, TARGET, Cell, straight
from simulator.traffic.recordings import RecordedTrack
from simulator.traffic.scripted_clips import SIZES_M, clip_of
from vehicle_agent.config import Body
from vehicle_agent.signals import CYCLIST

# Between the vehicle's side and the rider who overtakes.
_ASIDE_M = 1.0
# Of the rider's rear wheel before the bumper, where the rider turns in.
_AHEAD_M = 1.0
_SWERVE_S = 1.0
_ACROSS_MPS = 2.5
_DECEL_MPS2 = 3.0
# A slower motion to the side shows nothing: riders sway, and a tracker has noise.
_SHOWS_MPS = 0.5
# A rider who turns across nearer to the bumper than this meets the vehicle's side.
_ROOM_M = 0.3
_STEP_S = 0.02
_LASTS_S = 60.0
_RIDERS = (
    ("cyclist", 5.0, SIZES_M[CYCLIST]),
    ("cyclist-fast", 8.0, SIZES_M[CYCLIST]),
    ("scooter", 5.0, SCOOTER_SIZE_M),
    ("scooter-fast", 10.0, SCOOTER_SIZE_M),
)
_SHARES = (0.25, 0.5)
_MANOEUVRES = ("slows", "stops", "crosses")


@dataclass(frozen=True, slots=True)
class _TurnIn:
    """From the moment at which the rider begins to turn in.

    velocities (k, 2)  along and across the lane, one every _STEP_S
    met_step           the step at which the unbraked vehicle meets the rider
    begins_m           rider's rear before the bumper at the beginning
    """

    velocities: np.ndarray
    met_step: int
    begins_m: float


def from_behind(body: Body, light: str, speed_mps: float) -> Iterator[Cell]:
    """A rider overtakes on either side, turns in just ahead of the bumper, and slows, stops or crosses."""
    for name, faster_kmh, size_m in _RIDERS:
        rider_mps = speed_mps + faster_kmh * KMH
        for manoeuvre in _MANOEUVRES:
            for side, side_name in ((-1.0, "right"), (1.0, "left")):
                for share in _SHARES:
                    beside_m = 0.5 * (body.width_m + size_m[1]) + _ASIDE_M
                    inward_m = beside_m - (0.5 - share) * body.width_m
                    turn = _turn_in(manoeuvre, speed_mps, rider_mps, inward_m, size_m)
                    if turn is None:
                        continue
                    begins_s = max(BEFORE_S - turn.met_step * _STEP_S, 2.0)
                    path, start, meet = straight(speed_mps, begins_s + turn.met_step * _STEP_S)
                    track = _track(body, turn, start, speed_mps, begins_s, side, beside_m, size_m)
                    harmless_s = begins_s + _STEP_S * int(np.argmax(turn.velocities[:, 1] > _SHOWS_MPS))
                    yield Cell(
                        f"{light}-behind-{name}-{manoeuvre}-{side_name}-{share:.2f}-{speed_mps / KMH:.1f}",
                        f"from behind {name.split('-')[0]} {manoeuvre}",
                        light,
                        speed_mps,
                        path,
                        start,
                        meet,
                        clip_of("cell", (track,)),
                        harmless_s,
                    )


def _turn_in(
    manoeuvre: str, speed_mps: float, rider_mps: float, inward_m: float, size_m: tuple[float, float]
) -> _TurnIn | None:
    """The rider's motion; None if the vehicle's front does not meet it."""
    times_s = np.arange(0.0, _LASTS_S, _STEP_S)
    if manoeuvre == "crosses":
        eased = np.clip(1.0 - times_s / _SWERVE_S, 0.0, 1.0)
        velocities = np.column_stack((rider_mps * eased, _ACROSS_MPS * (1.0 - eased)))
        places = np.cumsum(velocities, axis=0) * _STEP_S
        met = int(np.searchsorted(places[:, 1], inward_m))
        # Turned, the rider is as deep as it is wide.
        deeper_m = 0.5 * (size_m[0] - size_m[1])
        begins_m = met * _STEP_S * speed_mps - float(places[met, 0]) - deeper_m
        return _TurnIn(velocities, met, begins_m) if begins_m > _ROOM_M else None
    final_mps = 0.5 * speed_mps if manoeuvre == "slows" else 0.0
    along = np.maximum(final_mps, rider_mps - _DECEL_MPS2 * np.maximum(times_s - _SWERVE_S, 0.0))
    # A smooth change of lane.
    across = np.where(
        times_s < _SWERVE_S, inward_m / _SWERVE_S * (1.0 - np.cos(2.0 * math.pi * times_s / _SWERVE_S)), 0.0
    )
    before_m = _AHEAD_M + np.cumsum(along - speed_mps) * _STEP_S
    met = int(np.argmax(before_m < 0.0))
    return _TurnIn(np.column_stack((along, across)), met, _AHEAD_M)


def _track(
    body: Body,
    turn: _TurnIn,
    start_m: float,
    speed_mps: float,
    begins_s: float,
    side: float,
    beside_m: float,
    size_m: tuple[float, float],
) -> RecordedTrack:
    """The rider from the beginning of the scene: at constant speed beside the lane, then turning in."""
    bumper_m = start_m + speed_mps * begins_s + body.front_overhang_m
    x_m, y_m = bumper_m + turn.begins_m + 0.5 * size_m[0], side * beside_m
    rider_mps = float(turn.velocities[0, 0])
    places = np.vstack(((0.0, 0.0), np.cumsum(turn.velocities, axis=0)[:-1] * _STEP_S))
    along, across = turn.velocities[:, 0], -side * turn.velocities[:, 1]
    yaws = np.arctan2(across, along)
    still = np.hypot(along, across) < 1e-6
    if still.any():
        yaws[still] = yaws[~still][-1]
    turning = np.column_stack((x_m + places[:, 0], y_m - side * places[:, 1], yaws, along, across))
    first = np.array([[x_m - rider_mps * begins_s, y_m, 0.0, rider_mps, 0.0]])
    times_s = np.concatenate(([0.0], begins_s + _STEP_S * np.arange(len(turning))))
    return RecordedTrack(TARGET, CYCLIST, times_s, np.vstack((first, turning)), size_m)
