"""Turn signals, headlights and horn: what the vehicle is about to do, for people outside.

Rules for the turn signal, the first that applies:
- hazard lights: a minimal-risk stop, held on the road, riders getting on or off;
- away from the kerb: the doors have closed and the vehicle sets off;
- to the side to which the planned way leaves the present one;
- whichever comes first: a turn at a junction, or to the kerb for a stop.
"""

import math
from collections.abc import Mapping

import msgspec
import numpy as np

from contract.geometry import project, wrap_angle
from contract.roads.model import Lane
from contract.roads.routing import ReferenceLine
from vehicle_agent.hmi.signs import is_arriving
from vehicle_agent.hmi.sunlight import sun_elevation_rad
from vehicle_agent.signals import GuardStatus, Headlights, Path, Task, TurnSignal, VehicleSignals

_OTHER: dict[TurnSignal, TurnSignal] = {"left": "right", "right": "left"}
# The planned way is compared with the line this far ahead of the rear axle.
_LOOK_M = 7.0


class SignallingState(msgspec.Struct, frozen=True):
    """turn, since_ns  shown since then
    served            doors have been open since the vehicle came to this stop
    served_ns         when it last served one, 0 never
    horn_ns           when the horn last began to sound, 0 never
    lights_ns         when the sun was last looked at, 0 never
    """

    turn: TurnSignal = "none"
    since_ns: int = 0
    served: bool = False
    served_ns: int = 0
    horn_ns: int = 0
    lights: Headlights = "low"
    lights_ns: int = 0


class VehicleSignalling(msgspec.Struct, frozen=True):
    """turns        the side of each lane that turns off, by its id
    kerb, turn_ahead_m, stop_ahead_m, headlights, horn  of the profile's `[signalling]`
    place_deg      latitude and longitude of the campus; None: lights whatever the sun does
    shift_m        the planned way leaves the present one by this much
    departing_ns   how long setting off from a stop is signalled
    show_ns        a turn signal stays this long
    horn_ns, horn_again_ns  how long the horn sounds, and the shortest time between two beginnings
    sun_ns         how often the sun's height is computed
    dusk_rad       the sun below this: lights
    """

    turns: Mapping[str, TurnSignal] = msgspec.field(default_factory=dict)
    kerb: TurnSignal = "right"
    turn_ahead_m: float = 25.0
    stop_ahead_m: float = 15.0
    headlights: str = "dusk"
    horn: str = "imminent_contact"
    place_deg: tuple[float, float] | None = None
    shift_m: float = 0.5
    departing_ns: int = 5_000_000_000
    show_ns: int = 2_000_000_000
    horn_ns: int = 500_000_000
    horn_again_ns: int = 10_000_000_000
    sun_ns: int = 60_000_000_000
    dusk_rad: float = 0.1

    def step(
        self, state: SignallingState, task: Task, path: Path, guard_status: GuardStatus, now_ns: int
    ) -> tuple[VehicleSignals, SignallingState]:
        """The signals now."""
        served = task.doors_open or (state.served and task.mode == "dwell")
        state = msgspec.structs.replace(state, served=served, served_ns=now_ns if served else state.served_ns)
        turn = self._turn(state, task, path, guard_status, now_ns)
        is_read = not state.since_ns or now_ns - state.since_ns >= self.show_ns
        if turn != state.turn and (is_read or "hazard" in (turn, state.turn)):
            state = msgspec.structs.replace(state, turn=turn, since_ns=now_ns)
        state = self._with_lights(state, task, now_ns)
        may_sound = self.horn != "never" and guard_status.imminent
        if may_sound and (not state.horn_ns or now_ns - state.horn_ns >= self.horn_again_ns):
            state = msgspec.structs.replace(state, horn_ns=now_ns)
        sounds = state.horn_ns > 0 and now_ns - state.horn_ns < self.horn_ns
        return VehicleSignals(state.turn, state.lights, sounds), state

    def _turn(
        self, state: SignallingState, task: Task, path: Path, guard_status: GuardStatus, now_ns: int
    ) -> TurnSignal:
        mode = guard_status.mode
        if mode == "manual":
            return "none"
        if mode in ("minimal_risk", "fault"):
            return "hazard"
        if mode == "held":
            # Before the first resume the vehicle rests where it was parked.
            return "none" if guard_status.reason == "just_started" else "hazard"
        if task.doors_open or (task.mode == "dwell" and not state.served):
            return "hazard"
        is_departing = state.served_ns > 0 and now_ns - state.served_ns < self.departing_ns
        if task.mode in ("drive", "dwell") and is_departing:
            return _OTHER[self.kerb]
        if task.mode != "drive" or task.line is None:
            return "none"
        return self._shift(task.line, task, path) or self._next_manoeuvre(task.line, task, path)

    def _shift(self, line: ReferenceLine, task: Task, path: Path) -> TurnSignal | None:
        """The side to which the planned way leaves the present one."""
        points = path.points_map
        if len(points) < 2:
            return None
        steps = np.hypot(np.diff(points[:, 0]), np.diff(points[:, 1]))
        ahead = int(np.searchsorted(np.cumsum(steps), _LOOK_M)) + 1
        if ahead >= len(points):
            return None
        first = int(np.searchsorted(line.s, task.s_m))
        last = int(np.searchsorted(line.s, task.s_m + 3.0 * _LOOK_M)) + 1
        _, d_m, _ = project(
            line.points, line.s, float(points[ahead, 0]), float(points[ahead, 1]), first, last
        )
        shift_m = d_m - task.d_m
        if not math.isfinite(shift_m) or abs(shift_m) < self.shift_m:
            return None
        return "left" if shift_m > 0.0 else "right"

    def _next_manoeuvre(self, line: ReferenceLine, task: Task, path: Path) -> TurnSignal:
        side, turn_m = self._next_turn(line, task.s_m)
        is_stopping = is_arriving(task, path, self.stop_ahead_m) and bool(
            task.stop_name or task.stop_name_en or task.reason == "requested_stop"
        )
        if is_stopping and path.stop_m < turn_m:
            return self.kerb
        return side

    def _next_turn(self, line: ReferenceLine, s_m: float) -> tuple[TurnSignal, float]:
        """(side, distance) of the turn that the rear axle is in, or that begins within turn_ahead_m."""
        if not self.turns:
            return "none", math.inf
        first = max(0, int(np.searchsorted(line.s, s_m, side="right")) - 1)
        last = int(np.searchsorted(line.s, s_m + self.turn_ahead_m, side="right"))
        numbers = line.lane_number[first:last]
        for number in dict.fromkeys(numbers.tolist()):
            side = self.turns.get(line.lane_ids[number], "none")
            if side != "none":
                begin = first + int(np.argmax(numbers == number))
                return side, max(0.0, float(line.s[begin]) - s_m)
        return "none", math.inf

    def _with_lights(self, state: SignallingState, task: Task, now_ns: int) -> SignallingState:
        if state.lights_ns and now_ns - state.lights_ns < self.sun_ns:
            return state
        lights: Headlights = "off" if self.headlights == "off" else "low"
        if self.headlights == "dusk" and self.place_deg is not None and task.utc_ns:
            is_day = sun_elevation_rad(task.utc_ns * 1e-9, *self.place_deg) > self.dusk_rad
            lights = "off" if is_day else "low"
        # Without the time the lights are on, and the time is asked for again in the next tick.
        looked_ns = now_ns if task.utc_ns else 0
        return msgspec.structs.replace(state, lights=lights, lights_ns=looked_ns)


def turns_of(lanes: tuple[Lane, ...], turn_rad: float = math.radians(30.0)) -> dict[str, TurnSignal]:
    """The side of each lane across a junction that turns off by more than turn_rad, by its id."""
    turns: dict[str, TurnSignal] = {}
    for lane in lanes:
        if lane.kind == "road":
            continue
        points = np.array(lane.points)
        steps = np.diff(points, axis=0)
        headings = np.arctan2(steps[:, 1], steps[:, 0])
        turned_rad = float(sum(wrap_angle(step) for step in np.diff(headings)))
        if abs(turned_rad) > turn_rad:
            turns[lane.lane_id] = "left" if turned_rad > 0.0 else "right"
    return turns
