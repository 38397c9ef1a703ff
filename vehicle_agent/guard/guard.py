"""The last room of the tick. Planning could be noise and this would still hold.

Read aloud: whoever overrides has the vehicle. What is broken stops it, until an operator says resume and
the cause is gone. Whoever is held stands still. Every command is finite and within limits; nobody throttles
and brakes; something within braking distance is braked for.
"""

import math

import msgspec

from contract.geometry import Array, inverse, transform_points
from contract.wire.messages import DriveMode, FaultRaised, ModeChanged, VehicleEvent
from vehicle_agent.guard.blocked import Standing, watched
from vehicle_agent.guard.bumper import distance_on_arc
from vehicle_agent.guard.faults import Ageing, begun, current
from vehicle_agent.signals import (
    Actuation,
    Ages,
    Ego,
    Fault,
    Guarded,
    Path,
    Task,
    VehicleMotion,
    Wish,
    World,
    fault_report,
)


class Watch(msgspec.Struct, frozen=True):
    """What the guard remembers.

    faults     active in the last tick; told: those that the server has been told of
    latched    what the minimal-risk stop is for
    manual     the safety driver has the vehicle until the next resume
    resumed_ns the last resume that was taken
    asking_since_ns  by-wire is wanted and not there since, 0 otherwise
    had_by_wire      by-wire was there since the last resume
    """

    mode: DriveMode = "held"
    reason: str = ""
    faults: tuple[Fault, ...] = ()
    told: tuple[Fault, ...] = ()
    latched: tuple[Fault, ...] = ()
    manual: bool = False
    resumed_ns: int = 0
    asking_since_ns: int = 0
    had_by_wire: bool = False
    stamp_ns: int = 0
    steer_rad: float = 0.0
    standing: Standing = Standing()
    events: tuple[VehicleEvent, ...] = ()


class Guard(msgspec.Struct, frozen=True):
    """Limits of the vehicle, SI units; stop_ratio: brake of a minimal-risk stop; hold_ratio: at rest.

    brake_delay_s, brake_mps2, margin_m   what the vehicle's own braking distance is made of
    by_wire_ns    how long the module may take to give the vehicle
    tell_after_ns a fault of a vehicle that is not driving is told when it lasts this long
    """

    wheelbase_m: float
    body_front_m: float
    half_width_m: float
    steer_rad_max: float
    steer_rate_radps_max: float
    speed_mps_max: float
    throttle_ratio_max: float = 0.7
    stop_ratio: float = 0.75
    hold_ratio: float = 0.5
    standing_mps: float = 0.1
    brake_delay_s: float = 0.3
    brake_mps2: float = 5.0
    margin_m: float = 0.3
    side_margin_m: float = 0.1
    ageing: Ageing = Ageing()
    by_wire_ns: int = 2_000_000_000
    tell_after_ns: int = 2_000_000_000
    blocked_after_ns: int = 60_000_000_000

    def initial(self) -> Watch:
        return Watch()

    def events(self, state: Watch) -> tuple[VehicleEvent, ...]:
        return state.events

    def step(
        self,
        state: Watch,
        wish: Wish,
        motion: VehicleMotion,
        ego: Ego,
        world: World,
        task: Task,
        path: Path,
        ages: Ages,
    ) -> tuple[Actuation, Guarded, Watch]:
        """The only actuation there is, and why."""
        finite = all(map(math.isfinite, (wish.steer_rad, wish.throttle_ratio, wish.brake_ratio)))
        faults = self._faults(state, motion, ego, world, ages, finite)
        new = self._latched(state, faults, motion, task)
        mode, reason = _mode(new, task, motion)
        standing, blocked = watched(state.standing, ego, task, path, self.blocked_after_ns)
        act, intervened = self._act(state, mode, wish if finite else None, motion, ego, world, task, path)
        told, news = self._news(state.told, faults, mode, ego.stamp_ns)
        changed = () if (mode, reason) == (state.mode, state.reason) else (ModeChanged(mode, reason),)
        new = msgspec.structs.replace(
            new,
            mode=mode,
            reason=reason,
            faults=faults,
            told=told,
            asking_since_ns=_asking_since(state, act, motion, ego.stamp_ns),
            stamp_ns=ego.stamp_ns,
            steer_rad=act.steer_rad,
            standing=standing,
            events=(*changed, *news, *blocked),
        )
        return act, Guarded(mode, intervened, _shown(faults, new.latched)), new

    def _faults(
        self, state: Watch, motion: VehicleMotion, ego: Ego, world: World, ages: Ages, finite: bool
    ) -> tuple[Fault, ...]:
        tick_ns = ego.stamp_ns - state.stamp_ns if state.stamp_ns else 0
        refused = 0 < state.asking_since_ns <= ego.stamp_ns - self.by_wire_ns and not motion.enabled
        late = refused and not motion.overridden
        found = current(ages, self.ageing, tick_ns, motion, ego, world, finite, late)
        return begun(found, state.faults, ego.stamp_ns)

    def _latched(self, state: Watch, faults: tuple[Fault, ...], motion: VehicleMotion, task: Task) -> Watch:
        """Take over by the driver, latch what must stop the vehicle, let go after an operator's resume."""
        stops = tuple(fault for fault in faults if fault.severity == "stop")
        manual, latched, had = state.manual, state.latched, state.had_by_wire or motion.enabled
        if task.resumed_ns > state.resumed_ns:
            manual, had = False, motion.enabled and not motion.overridden
            latched = ()
        waited_ns = task.resumed_ns and state.asking_since_ns and state.stamp_ns - state.asking_since_ns
        if motion.overridden and (had or waited_ns >= self.by_wire_ns):
            manual = True
        if task.mode != "hold" and not manual:
            codes = {fault.code for fault in latched}
            latched = latched + tuple(fault for fault in stops if fault.code not in codes)
        return msgspec.structs.replace(
            state, manual=manual, latched=latched, had_by_wire=had, resumed_ns=task.resumed_ns
        )

    def _act(
        self,
        state: Watch,
        mode: DriveMode,
        wish: Wish | None,
        motion: VehicleMotion,
        ego: Ego,
        world: World,
        task: Task,
        path: Path,
    ) -> tuple[Actuation, str]:
        if mode == "manual" or task.resumed_ns == 0:
            return Actuation(False, "park" if mode == "held" else "neutral", motion.steer_rad, 0.0, 0.0), ""
        steer_rad = self._steer_rad(state, wish, ego.stamp_ns)
        if not motion.enabled:
            # The module gives the vehicle only at zero pedals, and before that they have no effect anyway.
            return Actuation(True, "drive", motion.steer_rad, 0.0, 0.0), ""
        brakes = self._brakes(mode, wish, ego, motion, world, path, steer_rad)
        brake, intervened = max(brakes, key=lambda asked: asked[0])
        throttle = 0.0
        if wish is not None and brake <= 0.0 and mode == "autonomous":
            throttle = min(max(wish.throttle_ratio, 0.0), self.throttle_ratio_max)
        return Actuation(True, "drive", steer_rad, throttle, min(max(brake, 0.0), 1.0)), intervened

    def _brakes(
        self,
        mode: DriveMode,
        wish: Wish | None,
        ego: Ego,
        motion: VehicleMotion,
        world: World,
        path: Path,
        steer_rad: float,
    ) -> list[tuple[float, str]]:
        """Everybody's word on the brake; the hardest is taken, so that no two reasons cancel."""
        speed_mps = max(ego.speed_mps, motion.speed_mps)
        asked = [(0.0 if wish is None else wish.brake_ratio, "")]
        if mode in ("minimal_risk", "fault"):
            asked.append((self.stop_ratio, "minimal risk"))
        if mode != "autonomous" and speed_mps < self.standing_mps:
            asked.append((self.hold_ratio, ""))
        if path.emergency:
            asked.append((1.0, "emergency"))
        if speed_mps > 1.15 * self.speed_mps_max + 0.3:
            asked.append((self.stop_ratio, "overspeed"))
        if self._is_close(world, ego, steer_rad, speed_mps):
            asked.append((1.0, "obstacle"))
        return asked

    def _is_close(self, world: World, ego: Ego, steer_rad: float, speed_mps: float) -> bool:
        """Something ahead of the bumper is within the braking distance."""
        if speed_mps < self.standing_mps or len(world.points_map) == 0:
            return False
        look_m = speed_mps * self.brake_delay_s + speed_mps**2 / (2.0 * self.brake_mps2) + self.margin_m
        points: Array = transform_points(inverse(ego.pose_map), world.points_map)
        half_m = self.half_width_m + self.side_margin_m
        curvature_1pm = math.tan(steer_rad) / self.wheelbase_m
        return bool(distance_on_arc(points, curvature_1pm, self.body_front_m, half_m, look_m) <= look_m)

    def _steer_rad(self, state: Watch, wish: Wish | None, now_ns: int) -> float:
        """The wished angle within angle and rate limits; the last one where there is no wish."""
        if wish is None:
            return state.steer_rad
        wanted = min(max(wish.steer_rad, -self.steer_rad_max), self.steer_rad_max)
        dt_s = min(0.1, (now_ns - state.stamp_ns) * 1e-9) if state.stamp_ns else 0.02
        reach = self.steer_rate_radps_max * dt_s
        return state.steer_rad + min(max(wanted - state.steer_rad, -reach), reach)

    def _news(
        self, told: tuple[Fault, ...], faults: tuple[Fault, ...], mode: DriveMode, now_ns: int
    ) -> tuple[tuple[Fault, ...], tuple[FaultRaised, ...]]:
        """(faults told of by now, events). What is only not there yet at boot is not news at once."""
        known = {fault.code for fault in told}
        raised = tuple(
            fault
            for fault in faults
            if fault.code not in known
            and fault.severity != "info"
            and (mode not in ("held", "manual") or now_ns - fault.since_ns > self.tell_after_ns)
        )
        active = {fault.code for fault in faults}
        cleared = tuple(fault for fault in told if fault.code not in active)
        kept = tuple(fault for fault in told if fault.code in active)
        events = tuple(FaultRaised(fault_report(fault)) for fault in raised)
        return kept + raised, events + tuple(FaultRaised(fault_report(fault), True) for fault in cleared)


def _mode(watch: Watch, task: Task, motion: VehicleMotion) -> tuple[DriveMode, str]:
    if watch.manual:
        return "manual", "takeover: the safety driver has the vehicle"
    if watch.latched:
        codes = ", ".join(fault.code for fault in watch.latched)
        return ("minimal_risk" if motion.enabled else "fault"), codes
    if task.mode == "hold":
        return "held", task.reason
    return "autonomous", ""


def _asking_since(state: Watch, act: Actuation, motion: VehicleMotion, now_ns: int) -> int:
    if not act.enable or motion.enabled:
        return 0
    return state.asking_since_ns or now_ns


def _shown(faults: tuple[Fault, ...], latched: tuple[Fault, ...]) -> tuple[Fault, ...]:
    """Active faults, and those that are over but still hold the vehicle."""
    active = {fault.code for fault in faults}
    return faults + tuple(fault for fault in latched if fault.code not in active)
