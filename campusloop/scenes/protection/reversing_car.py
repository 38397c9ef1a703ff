"""Cars that reverse: out of a parking bay across the lane, and in the lane towards the vehicle."""

import math
from collections.abc import Iterator

from campusloop.scenes.protection.cell import BEFORE_S, KMH, PARKED, SHARES, TARGET, Cell, straight
from simulator.traffic.recordings import RecordedTrack
from simulator.traffic.scripted_clips import SIZES_M, clip_of, standing, walker
from vehicle_agent.config import Body
from vehicle_agent.signals import VEHICLE

_LENGTH_M, _WIDTH_M = SIZES_M[VEHICLE]
_VAN_SIZE_M = (5.0, 2.0)
# From the rear of the parked cars to the vehicle's side, and between two parked cars.
_BAY_M, _BETWEEN_M = 1.0, 0.6
# Beside a van, the car stands this much deeper in its bay.
_DEEPER_M = 1.0


def reversing_car(body: Body, light: str, speed_mps: float) -> Iterator[Cell]:
    """Out of a bay on either side, in the open and beside a van; and straight towards the vehicle."""
    for hidden, where in ((False, "bay"), (True, "bay-beside-van")):
        for target_kmh in (3.0, 5.0, 8.0):
            for side, side_name in ((-1.0, "near"), (1.0, "far")):
                for share in SHARES:
                    path, start, meet = straight(speed_mps)
                    front_m = meet + body.front_overhang_m
                    name = f"{where}-{target_kmh:.0f}-{side_name}-{share:.2f}-{speed_mps / KMH:.1f}"
                    from_m = _BAY_M + (_DEEPER_M if hidden else 0.0)
                    car, begins_s = _out_of_bay(body, front_m, side, share, target_kmh * KMH, from_m)
                    tracks = [car]
                    if hidden:
                        van_m = front_m + 0.5 * _WIDTH_M - 0.5 * (_WIDTH_M + _VAN_SIZE_M[1]) - _BETWEEN_M
                        aside_m = side * (0.5 * body.width_m + _BAY_M + 0.5 * _VAN_SIZE_M[0])
                        tracks.append(standing(PARKED, VEHICLE, van_m, aside_m, 0.5 * math.pi, _VAN_SIZE_M))
                    yield Cell(
                        f"{light}-reverses-{name}",
                        f"reversing car {where}",
                        light,
                        speed_mps,
                        path,
                        start,
                        meet,
                        clip_of("cell", tuple(tracks)),
                        # Until it moves it is a parked car.
                        begins_s,
                    )
    for target_kmh in (3.0, 5.0):
        for share in (0.25, 0.5):
            path, start, meet = straight(speed_mps)
            target_mps = target_kmh * KMH
            y_m = -(0.5 - share) * (body.width_m + _WIDTH_M)
            begin_m = meet + body.front_overhang_m + 0.5 * _LENGTH_M + target_mps * BEFORE_S
            places = ((begin_m, y_m), (begin_m - 60.0, y_m))
            yield Cell(
                f"{light}-reverses-towards-{target_kmh:.0f}-{share:.2f}-{speed_mps / KMH:.1f}",
                "reversing car towards",
                light,
                speed_mps,
                path,
                start,
                meet,
                clip_of("cell", (_backwards(walker(TARGET, VEHICLE, places, target_mps)),)),
            )


def _out_of_bay(
    body: Body, front_m: float, side: float, share: float, target_mps: float, from_m: float
) -> tuple[RecordedTrack, float]:
    """A car that reverses, and when it begins to.

    Its rear begins from_m beside the vehicle's side, and has come over `share` of the front's width when the
    bumper is at its side.
    """
    rear_m = side * (0.5 - share) * body.width_m
    met_m = rear_m + side * 0.5 * _LENGTH_M
    way_m = min(share * body.width_m + from_m, target_mps * BEFORE_S)
    x_m = front_m + 0.5 * _WIDTH_M
    places = ((x_m, met_m + side * way_m), (x_m, met_m - side * (8.0 + _LENGTH_M)))
    begins_s = BEFORE_S - way_m / target_mps
    return _backwards(walker(TARGET, VEHICLE, places, target_mps, begins_s)), begins_s


def _backwards(track: RecordedTrack) -> RecordedTrack:
    """The same motion by a car that looks the other way."""
    states = track.states.copy()
    states[:, 2] += math.pi
    return RecordedTrack(track.number, track.kind, track.times_s, states, track.size_m)
