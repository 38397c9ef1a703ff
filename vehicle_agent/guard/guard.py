"""The last room of the tick: its rules hold whatever planning and control ask for.

- A safety driver who overrides has the vehicle until the next resume.
- A fault of severity `stop` ends in a minimal-risk stop, until an operator resumes and its cause is gone.
  That of a lost vehicle also ends once its place is proven.
- A held vehicle stands still, and a standing vehicle does not roll.
- Every command is finite and within limits; throttle and brake are never applied together.
- The vehicle brakes for a contact ahead, just enough, or fully when needed.
- It passes people at its flanks slowly; they do not stop it.
- A standing vehicle does not set off while a road user is within its footprint's margins.
"""

import math

import msgspec

from contract.wire.messages import DriveMode, ModeChanged, VehicleEvent
from contract.wire.reasons import FaultCode, HoldReason
from vehicle_agent.guard.blocked import BlockedState, watch_blocked
from vehicle_agent.guard.collision import Avoidance
from vehicle_agent.guard.faults import (
    AgeLimits,
    current_faults,
    fault_events,
    is_by_wire_sound,
    reported_faults,
    with_start_times,
)
from vehicle_agent.guard.limits import Limits
from vehicle_agent.signals import (
    GATE_BRAKING,
    Actuation,
    Ages,
    ControlCommand,
    Ego,
    Fault,
    GuardStatus,
    Path,
    Task,
    VehicleMotion,
    World,
)


class GuardState(msgspec.Struct, frozen=True):
    """What the guard remembers.

    faults, reported   faults active in the last tick, and those reported to the server
    latched            faults that the minimal-risk stop is for
    lost_ns            last tick in which the vehicle was lost since something latched, 0 none
    manual             the safety driver has the vehicle until the next resume
    resumed_ns         stamp of the last resume that took effect
    resume_tick_ns     stamp of its tick while the gate still brakes, 0 otherwise
    requested_since_ns  since when by-wire is requested and not enabled, 0 otherwise
    had_by_wire        by-wire was enabled since the last resume
    allowed_mps        the speed allowed in the last tick
    avoiding           the guard braked, or kept the vehicle from setting off, to avoid a contact
    blocked            see `BlockedState`
    """

    mode: DriveMode = "held"
    reason: HoldReason | None = None
    detail: str = ""
    faults: tuple[Fault, ...] = ()
    reported: tuple[Fault, ...] = ()
    latched: tuple[Fault, ...] = ()
    lost_ns: int = 0
    manual: bool = False
    resumed_ns: int = 0
    resume_tick_ns: int = 0
    requested_since_ns: int = 0
    had_by_wire: bool = False
    stamp_ns: int = 0
    steer_rad: float = 0.0
    allowed_mps: float = 0.0
    avoiding: bool = False
    avoiding_ratio: float = 0.0
    blocked: BlockedState = BlockedState()
    events: tuple[VehicleEvent, ...] = ()


class Guard(msgspec.Struct, frozen=True):
    """The guard's parameters; brake ratios are pedal positions, 0..1.

    stop_ratio       of a minimal-risk stop; firm_ratio: of one for a fault between the tick and the wheels,
                     where the next command may not arrive
    slow_ratio       to come down to a speed limit; hold_ratio: at rest
    standing_mps     a slower vehicle stands
    by_wire_ns       how long the module, or the gate, may take to enable by-wire
    report_after_ns  a fault of a vehicle that is not driving is reported when it lasts this long
    blocked_after_ns  a vehicle that stands this long for an obstacle is reported as blocked
    """

    limits: Limits
    avoidance: Avoidance
    stop_ratio: float
    firm_ratio: float
    slow_ratio: float
    hold_ratio: float = 0.5
    standing_mps: float = 0.1
    ageing: AgeLimits = AgeLimits()
    by_wire_ns: int = 2_000_000_000
    report_after_ns: int = 2_000_000_000
    blocked_after_ns: int = 60_000_000_000

    def initial(self) -> GuardState:
        return GuardState()

    def events(self, state: GuardState) -> tuple[VehicleEvent, ...]:
        return state.events

    def step(
        self,
        state: GuardState,
        command: ControlCommand,
        motion: VehicleMotion,
        ego: Ego,
        world: World,
        task: Task,
        path: Path,
        ages: Ages,
    ) -> tuple[Actuation, GuardStatus, GuardState]:
        """The actuation, and the guard's status."""
        finite = all(map(math.isfinite, (command.steer_rad, command.throttle_ratio, command.brake_ratio)))
        dt_s = (ego.stamp_ns - state.stamp_ns) * 1e-9 if state.stamp_ns else 0.0
        faults = self._faults(state, motion, ego, world, ages, finite)
        new = self._latched(state, faults, motion, ego, task)
        allowed_mps = self.limits.speed_mps(state.allowed_mps, ego.position_std_m, dt_s)
        new = msgspec.structs.replace(new, faults=faults, allowed_mps=allowed_mps)
        mode, reason, detail = _mode(new, task, motion)
        actuation, intervened = self._actuation(
            new, mode, command if finite else None, motion, ego, world, task, path
        )
        blocked, blocked_events = watch_blocked(state.blocked, ego, task, path, self.blocked_after_ns)
        reported, raised = fault_events(state.reported, faults, mode, ego.stamp_ns, self.report_after_ns)
        changed = _mode_changed(state, new, mode, reason, detail)
        new = msgspec.structs.replace(
            new,
            mode=mode,
            reason=reason,
            detail=detail,
            reported=reported,
            requested_since_ns=_requested_since(state, actuation, motion, ego.stamp_ns),
            stamp_ns=ego.stamp_ns,
            steer_rad=actuation.steer_rad,
            avoiding=intervened in _AVOIDING,
            avoiding_ratio=actuation.brake_ratio if intervened == _OBSTACLE else 0.0,
            blocked=blocked,
            events=(*changed, *raised, *blocked_events),
        )
        imminent = intervened == _OBSTACLE and actuation.brake_ratio >= 1.0
        return (
            actuation,
            GuardStatus(mode, intervened, reported_faults(faults, new.latched), reason, detail, imminent),
            new,
        )

    def _faults(
        self, state: GuardState, motion: VehicleMotion, ego: Ego, world: World, ages: Ages, finite: bool
    ) -> tuple[Fault, ...]:
        tick_ns = ego.stamp_ns - state.stamp_ns if state.stamp_ns else 0
        refused = 0 < state.requested_since_ns <= ego.stamp_ns - self.by_wire_ns and not motion.enabled
        late = refused and not motion.overridden
        found = current_faults(ages, self.ageing, tick_ns, motion, ego, world, finite, late)
        return with_start_times(found, state.faults, ego.stamp_ns)

    def _latched(
        self, state: GuardState, faults: tuple[Fault, ...], motion: VehicleMotion, ego: Ego, task: Task
    ) -> GuardState:
        """The state with takeover, latched faults and resume brought up to date."""
        stops = tuple(fault for fault in faults if fault.severity == "stop")
        manual, latched, had = state.manual, state.latched, state.had_by_wire or motion.enabled
        resume_tick_ns = state.resume_tick_ns
        if task.resumed_ns not in (0, state.resumed_ns):
            manual, had = False, motion.enabled and not motion.overridden
            latched, resume_tick_ns = (), ego.stamp_ns
        if not _gate_brakes(motion):
            resume_tick_ns = 0
        elif resume_tick_ns > 0 and ego.stamp_ns - resume_tick_ns < self.by_wire_ns:
            # The gate releases its brake only after a new enable request, which the resume has just started.
            stops = tuple(fault for fault in stops if not _is_of_gate(fault))
        waited_ns = task.resumed_ns and state.requested_since_ns and state.stamp_ns - state.requested_since_ns
        if motion.overridden and (had or waited_ns >= self.by_wire_ns):
            manual = True
        if task.mode != "hold" and not manual:
            codes = {fault.code for fault in latched}
            latched = latched + tuple(fault for fault in stops if fault.code not in codes)
        lost_ns = 0 if not latched else ego.stamp_ns if ego.phase == "lost" else state.lost_ns
        if latched and not stops and motion.enabled and _is_found_again(latched, lost_ns, ego):
            latched, lost_ns = (), 0
        return msgspec.structs.replace(
            state,
            manual=manual,
            latched=latched,
            lost_ns=lost_ns,
            had_by_wire=had,
            resumed_ns=task.resumed_ns,
            resume_tick_ns=resume_tick_ns,
        )

    def _actuation(
        self,
        state: GuardState,
        mode: DriveMode,
        command: ControlCommand | None,
        motion: VehicleMotion,
        ego: Ego,
        world: World,
        task: Task,
        path: Path,
    ) -> tuple[Actuation, str]:
        if mode == "manual" or task.resumed_ns == 0:
            return Actuation(False, "park" if mode == "held" else "neutral", motion.steer_rad, 0.0, 0.0), ""
        if state.resume_tick_ns == ego.stamp_ns and _gate_brakes(motion):
            # One tick without enable: the gate expects the new request in two frames.
            return Actuation(False, "drive", motion.steer_rad, 0.0, 0.0), ""
        if not motion.enabled:
            # The module enables only at zero pedals; before that, pedals have no effect.
            return Actuation(True, "drive", motion.steer_rad, 0.0, 0.0), ""
        steer_rad = self._steer_rad(state, command, ego.stamp_ns)
        throttle = 0.0
        may_drive = mode == "autonomous" and task.mode == "drive" and not task.doors_open
        if command is not None and may_drive:
            throttle = min(max(command.throttle_ratio, 0.0), self.limits.throttle_ratio_max)
        brakes = self._brakes(state, mode, command, throttle, ego, motion, world, path, steer_rad)
        brake, intervened = max(brakes, key=lambda request: request[0])
        if brake > 0.0 or max(ego.speed_mps, motion.speed_mps) > state.allowed_mps + _OVERSHOOT_MPS:
            throttle = 0.0
        return Actuation(True, "drive", steer_rad, throttle, min(max(brake, 0.0), 1.0)), intervened

    def _steer_rad(self, state: GuardState, command: ControlCommand | None, stamp_ns: int) -> float:
        """The commanded wheel angle within the limits; the last one without a command."""
        if command is None:
            return state.steer_rad
        dt_s = min(0.1, (stamp_ns - state.stamp_ns) * 1e-9) if state.stamp_ns else 0.02
        return self.limits.steer_rad(state.steer_rad, command.steer_rad, max(dt_s, 0.0))

    def _brakes(
        self,
        state: GuardState,
        mode: DriveMode,
        command: ControlCommand | None,
        throttle: float,
        ego: Ego,
        motion: VehicleMotion,
        world: World,
        path: Path,
        steer_rad: float,
    ) -> list[tuple[float, str]]:
        """(brake pedal, reason) of each rule; the hardest is applied, so that no two rules cancel."""
        speed_mps = max(ego.speed_mps, motion.speed_mps)
        stands = abs(motion.speed_mps) < self.standing_mps and speed_mps < self.standing_mps
        requests = [(0.0 if command is None else command.brake_ratio, "")]
        if mode in ("minimal_risk", "fault"):
            ratio = self.stop_ratio if is_by_wire_sound(state.latched) else self.firm_ratio
            requests.append((ratio, "minimal risk"))
        if stands and throttle == 0.0:
            requests.append((self.hold_ratio, ""))
        if motion.speed_mps <= -self.standing_mps:
            requests.append((self.stop_ratio, "rolling back"))
        if path.emergency:
            requests.append((1.0, "emergency"))
        if self.limits.is_over(speed_mps, self.limits.speed_mps_max):
            requests.append((self.stop_ratio, "overspeed"))
        elif self.limits.is_over(speed_mps, state.allowed_mps):
            requests.append((self.slow_ratio, "overspeed"))
        if any(fault.code == "tracks_not_finite" for fault in state.faults):
            requests.append((self.slow_ratio, "tracks not finite"))
        else:
            requests += self._collision_brakes(
                state, throttle, ego, motion, world, steer_rad, speed_mps, stands
            )
        return requests

    def _collision_brakes(
        self,
        state: GuardState,
        throttle: float,
        ego: Ego,
        motion: VehicleMotion,
        world: World,
        steer_rad: float,
        speed_mps: float,
        stands: bool,
    ) -> list[tuple[float, str]]:
        movers, obstacles = self.avoidance.road_users(world, ego)
        if len(obstacles) == 0:
            return []
        if stands:
            free = throttle == 0.0 or self.avoidance.may_set_off(movers, obstacles, steer_rad)
            return [] if free else [(self.hold_ratio, _CLOSE)]
        requests = []
        ratio = self.avoidance.brake_ratio(obstacles, ego, motion, steer_rad, speed_mps, state.avoiding)
        if ratio > 0.0:
            # No less than before: a brake that follows every estimate of the track follows it with its lag.
            requests.append((max(ratio, state.avoiding_ratio), _OBSTACLE))
        elif self.avoidance.is_creeping_up(movers, speed_mps):
            requests.append((self.hold_ratio, _CLOSE))
        over_mps = speed_mps - self.avoidance.alongside_mps(movers)
        if over_mps > 0.0:
            # As gently as it is over: nobody inside falls because somebody walks past outside.
            requests.append((self.slow_ratio * min(1.0, over_mps / _GENTLY_MPS), _ALONGSIDE))
        return requests


_OBSTACLE, _CLOSE, _ALONGSIDE = "obstacle", "somebody close", "somebody alongside"
_AVOIDING = (_OBSTACLE, _CLOSE)
# Overshoot of a healthy speed controller.
_OVERSHOOT_MPS = 0.3
# So much above the speed beside people, the brake is the one that comes down to a speed limit.
_GENTLY_MPS = 0.5


# What a lost vehicle stops for, and what being lost and found leaves behind.
_OF_BEING_LOST = ("pose_poor", "pose_stale", "pose_jump")


def _is_found_again(latched: tuple[Fault, ...], lost_ns: int, ego: Ego) -> bool:
    """Whether the stop was for a lost pose alone, and the place has been proven since."""
    return 0 < lost_ns < ego.proven_ns and all(fault.code in _OF_BEING_LOST for fault in latched)


def _gate_brakes(motion: VehicleMotion) -> bool:
    return any(map(_is_of_gate, motion.faults))


def _is_of_gate(fault: Fault) -> bool:
    """The gate's fault code ends in its cause."""
    return fault.code.startswith(GATE_BRAKING)


def _mode(state: GuardState, task: Task, motion: VehicleMotion) -> tuple[DriveMode, HoldReason | None, str]:
    """(mode, why the vehicle does not drive by itself, detail of that)."""
    if state.manual:
        return "manual", "takeover", ""
    if state.latched:
        return ("minimal_risk" if motion.enabled else "fault"), "fault", ""
    if task.mode == "hold":
        return "held", task.hold_reason, task.hold_detail
    return "autonomous", None, ""


def _mode_changed(
    before: GuardState, now: GuardState, mode: DriveMode, reason: HoldReason | None, detail: str
) -> tuple[ModeChanged, ...]:
    """The event of another mode, or of other reasons for the same one."""
    if (mode, reason, detail, _codes(now)) == (before.mode, before.reason, before.detail, _codes(before)):
        return ()
    return (ModeChanged(mode, reason, detail, _codes(now) if reason == "fault" else ()),)


def _codes(state: GuardState) -> tuple[FaultCode, ...]:
    return tuple(fault.code for fault in state.latched)


def _requested_since(state: GuardState, actuation: Actuation, motion: VehicleMotion, now_ns: int) -> int:
    if not actuation.enable or motion.enabled:
        return 0
    return state.requested_since_ns or now_ns
