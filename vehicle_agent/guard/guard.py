"""The last room of the tick. Planning could be noise and this would still hold.

Read aloud: whoever overrides has the vehicle. What is broken stops it, until an operator says resume and
the cause is gone. Whoever is held stands still, and who stands does not roll. Every command is finite and
within limits; nobody throttles and brakes. Whoever would be touched is braked for, just enough, fully when
needed; while somebody is at the body, it does not set off.
"""

import math

import msgspec

from contract.wire.messages import DriveMode, ModeChanged, VehicleEvent
from vehicle_agent.guard.blocked import BlockedState, watched
from vehicle_agent.guard.collision import Avoidance
from vehicle_agent.guard.faults import AgeLimits, begun, current, news, only_senses, shown
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

    faults     active in the last tick; told: those that the server has been told of
    latched    what the minimal-risk stop is for
    manual     the safety driver has the vehicle until the next resume
    resumed_ns the last resume that was taken
    resume_tick_ns   its tick, as long as the gate has not let go since, 0 otherwise
    asking_since_ns  by-wire is wanted and not there since, 0 otherwise
    had_by_wire      by-wire was there since the last resume
    allowed_mps      the speed that was allowed in the last tick
    avoiding         the vehicle was braked, or kept from setting off, for somebody
    """

    mode: DriveMode = "held"
    reason: str = ""
    faults: tuple[Fault, ...] = ()
    told: tuple[Fault, ...] = ()
    latched: tuple[Fault, ...] = ()
    manual: bool = False
    resumed_ns: int = 0
    resume_tick_ns: int = 0
    asking_since_ns: int = 0
    had_by_wire: bool = False
    stamp_ns: int = 0
    steer_rad: float = 0.0
    allowed_mps: float = 0.0
    avoiding: bool = False
    standing: BlockedState = BlockedState()
    events: tuple[VehicleEvent, ...] = ()


class Guard(msgspec.Struct, frozen=True):
    """stop_ratio: brake of a minimal-risk stop; hold_ratio: at rest; slow_ratio: to come down to a limit.

    firm_ratio    of one for what is between the tick and the wheels, where the next command may not arrive
    by_wire_ns    how long the module, or the gate, may take to give the vehicle
    tell_after_ns a fault of a vehicle that is not driving is told when it lasts this long
    """

    limits: Limits
    avoidance: Avoidance
    stop_ratio: float = 0.75
    firm_ratio: float = 0.85
    slow_ratio: float = 0.6
    hold_ratio: float = 0.5
    standing_mps: float = 0.1
    ageing: AgeLimits = AgeLimits()
    by_wire_ns: int = 2_000_000_000
    tell_after_ns: int = 2_000_000_000
    blocked_after_ns: int = 60_000_000_000

    def initial(self) -> GuardState:
        return GuardState()

    def events(self, state: GuardState) -> tuple[VehicleEvent, ...]:
        return state.events

    def step(
        self,
        state: GuardState,
        wish: ControlCommand,
        motion: VehicleMotion,
        ego: Ego,
        world: World,
        task: Task,
        path: Path,
        ages: Ages,
    ) -> tuple[Actuation, GuardStatus, GuardState]:
        """The only actuation there is, and why."""
        finite = all(map(math.isfinite, (wish.steer_rad, wish.throttle_ratio, wish.brake_ratio)))
        dt_s = (ego.stamp_ns - state.stamp_ns) * 1e-9 if state.stamp_ns else 0.0
        faults = self._faults(state, motion, ego, world, ages, finite)
        new = self._latched(state, faults, motion, ego, task)
        allowed_mps = self.limits.speed_mps(state.allowed_mps, ego.position_std_m, dt_s)
        new = msgspec.structs.replace(new, faults=faults, allowed_mps=allowed_mps)
        mode, reason = _mode(new, task, motion)
        act, intervened = self._act(new, mode, wish if finite else None, motion, ego, world, task, path)
        standing, blocked = watched(state.standing, ego, task, path, self.blocked_after_ns)
        told, told_now = news(state.told, faults, mode, ego.stamp_ns, self.tell_after_ns)
        changed = () if (mode, reason) == (state.mode, state.reason) else (ModeChanged(mode, reason),)
        new = msgspec.structs.replace(
            new,
            mode=mode,
            reason=reason,
            told=told,
            asking_since_ns=_asking_since(state, act, motion, ego.stamp_ns),
            stamp_ns=ego.stamp_ns,
            steer_rad=act.steer_rad,
            avoiding=intervened in _AVOIDING,
            standing=standing,
            events=(*changed, *told_now, *blocked),
        )
        return act, GuardStatus(mode, intervened, shown(faults, new.latched)), new

    def _faults(
        self, state: GuardState, motion: VehicleMotion, ego: Ego, world: World, ages: Ages, finite: bool
    ) -> tuple[Fault, ...]:
        tick_ns = ego.stamp_ns - state.stamp_ns if state.stamp_ns else 0
        refused = 0 < state.asking_since_ns <= ego.stamp_ns - self.by_wire_ns and not motion.enabled
        late = refused and not motion.overridden
        found = current(ages, self.ageing, tick_ns, motion, ego, world, finite, late)
        return begun(found, state.faults, ego.stamp_ns)

    def _latched(
        self, state: GuardState, faults: tuple[Fault, ...], motion: VehicleMotion, ego: Ego, task: Task
    ) -> GuardState:
        """Take over by the driver, latch what must stop the vehicle, let go after an operator's resume."""
        stops = tuple(fault for fault in faults if fault.severity == "stop")
        manual, latched, had = state.manual, state.latched, state.had_by_wire or motion.enabled
        resume_tick_ns = state.resume_tick_ns
        if task.resumed_ns not in (0, state.resumed_ns):
            manual, had = False, motion.enabled and not motion.overridden
            latched, resume_tick_ns = (), ego.stamp_ns
        if not _gate_brakes(motion):
            resume_tick_ns = 0
        elif resume_tick_ns > 0 and ego.stamp_ns - resume_tick_ns < self.by_wire_ns:
            # The gate lets go only when by-wire is asked for anew, which the resume has just begun.
            stops = tuple(fault for fault in stops if not _is_of_gate(fault))
        waited_ns = task.resumed_ns and state.asking_since_ns and state.stamp_ns - state.asking_since_ns
        if motion.overridden and (had or waited_ns >= self.by_wire_ns):
            manual = True
        if task.mode != "hold" and not manual:
            codes = {fault.code for fault in latched}
            latched = latched + tuple(fault for fault in stops if fault.code not in codes)
        return msgspec.structs.replace(
            state,
            manual=manual,
            latched=latched,
            had_by_wire=had,
            resumed_ns=task.resumed_ns,
            resume_tick_ns=resume_tick_ns,
        )

    def _act(
        self,
        state: GuardState,
        mode: DriveMode,
        wish: ControlCommand | None,
        motion: VehicleMotion,
        ego: Ego,
        world: World,
        task: Task,
        path: Path,
    ) -> tuple[Actuation, str]:
        if mode == "manual" or task.resumed_ns == 0:
            return Actuation(False, "park" if mode == "held" else "neutral", motion.steer_rad, 0.0, 0.0), ""
        if state.resume_tick_ns == ego.stamp_ns and _gate_brakes(motion):
            # One tick without enable, so that by-wire is asked for anew in two frames.
            return Actuation(False, "drive", motion.steer_rad, 0.0, 0.0), ""
        if not motion.enabled:
            # The module gives the vehicle only at zero pedals, and before that they have no effect anyway.
            return Actuation(True, "drive", motion.steer_rad, 0.0, 0.0), ""
        steer_rad = state.steer_rad
        if wish is not None:
            dt_s = min(0.1, (ego.stamp_ns - state.stamp_ns) * 1e-9) if state.stamp_ns else 0.02
            steer_rad = self.limits.steer_rad(steer_rad, wish.steer_rad, max(dt_s, 0.0))
        throttle = 0.0
        may_drive = mode == "autonomous" and task.mode == "drive" and not task.doors_open
        if wish is not None and may_drive:
            throttle = min(max(wish.throttle_ratio, 0.0), self.limits.throttle_ratio_max)
        brakes = self._brakes(state, mode, wish, throttle, ego, motion, world, path, steer_rad)
        brake, intervened = max(brakes, key=lambda asked: asked[0])
        if brake > 0.0 or max(ego.speed_mps, motion.speed_mps) > state.allowed_mps + _OVERSHOOT_MPS:
            throttle = 0.0
        return Actuation(True, "drive", steer_rad, throttle, min(max(brake, 0.0), 1.0)), intervened

    def _brakes(
        self,
        state: GuardState,
        mode: DriveMode,
        wish: ControlCommand | None,
        throttle: float,
        ego: Ego,
        motion: VehicleMotion,
        world: World,
        path: Path,
        steer_rad: float,
    ) -> list[tuple[float, str]]:
        """Everybody's word on the brake; the hardest is taken, so that no two reasons cancel."""
        speed_mps = max(ego.speed_mps, motion.speed_mps)
        stands = abs(motion.speed_mps) < self.standing_mps and speed_mps < self.standing_mps
        asked = [(0.0 if wish is None else wish.brake_ratio, "")]
        if mode in ("minimal_risk", "fault"):
            ratio = self.stop_ratio if only_senses(state.latched) else self.firm_ratio
            asked.append((ratio, "minimal risk"))
        if stands and throttle == 0.0:
            asked.append((self.hold_ratio, ""))
        if motion.speed_mps <= -self.standing_mps:
            asked.append((self.stop_ratio, "rolling back"))
        if path.emergency:
            asked.append((1.0, "emergency"))
        if self.limits.is_over(speed_mps, self.limits.speed_mps_max):
            asked.append((self.stop_ratio, "overspeed"))
        elif self.limits.is_over(speed_mps, state.allowed_mps):
            asked.append((self.slow_ratio, "overspeed"))
        if any(fault.code == "tracks_not_finite" for fault in state.faults):
            asked.append((self.slow_ratio, "tracks not finite"))
        else:
            asked.append(self._for_others(state, throttle, ego, motion, world, steer_rad, speed_mps, stands))
        return asked

    def _for_others(
        self,
        state: GuardState,
        throttle: float,
        ego: Ego,
        motion: VehicleMotion,
        world: World,
        steer_rad: float,
        speed_mps: float,
        stands: bool,
    ) -> tuple[float, str]:
        movers, everything = self.avoidance.others(world, ego)
        if len(everything) == 0:
            return 0.0, ""
        if stands:
            free = throttle == 0.0 or self.avoidance.may_set_off(movers, everything, steer_rad)
            return (0.0, "") if free else (self.hold_ratio, _CLOSE)
        ratio = self.avoidance.brake_ratio(everything, ego, motion, steer_rad, speed_mps, state.avoiding)
        if ratio == 0.0 and self.avoidance.is_creeping_up(movers, speed_mps):
            return self.hold_ratio, _CLOSE
        return (ratio, _OBSTACLE) if ratio > 0.0 else (0.0, "")


_OBSTACLE, _CLOSE = "obstacle", "somebody close"
_AVOIDING = (_OBSTACLE, _CLOSE)
# A speed controller at its set point.
_OVERSHOOT_MPS = 0.3


def _gate_brakes(motion: VehicleMotion) -> bool:
    return any(map(_is_of_gate, motion.faults))


def _is_of_gate(fault: Fault) -> bool:
    """Its code goes on with the cause."""
    return fault.code.startswith(GATE_BRAKING)


def _mode(watch: GuardState, task: Task, motion: VehicleMotion) -> tuple[DriveMode, str]:
    if watch.manual:
        return "manual", "takeover: the safety driver has the vehicle"
    if watch.latched:
        codes = ", ".join(fault.code for fault in watch.latched)
        return ("minimal_risk" if motion.enabled else "fault"), codes
    if task.mode == "hold":
        return "held", task.reason
    return "autonomous", ""


def _asking_since(state: GuardState, act: Actuation, motion: VehicleMotion, now_ns: int) -> int:
    if not act.enable or motion.enabled:
        return 0
    return state.asking_since_ns or now_ns
