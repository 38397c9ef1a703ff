"""The allowances that the Snow Lion stack makes for people, each of which can be taken away."""

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import msgspec

from simulator.sensors.tracker import TrackerNoise
from vehicle_agent.guard.guard import Guard
from vehicle_agent.onboard.car import Car
from vehicle_agent.planning.behaviour.decide import BehaviourRules
from vehicle_agent.planning.motion.request import ClearanceLaw, MotionParams


def _same(value: Any) -> Any:
    return value


@dataclass(frozen=True, slots=True)
class Allowance:
    """One allowance, and the planner, rooms or tracker without it; `what` says what is taken away."""

    name: str
    what: str
    motion: Callable[[MotionParams], MotionParams] = _same
    rules: Callable[[BehaviourRules], BehaviourRules] = _same
    car: Callable[[Car], Car] = _same
    tracker: TrackerNoise | None = None


def _motion(**changes: object) -> Callable[[MotionParams], MotionParams]:
    return lambda params: msgspec.structs.replace(params, **changes)


def _room(**changes: float) -> Callable[[MotionParams], MotionParams]:
    return lambda params: msgspec.structs.replace(params, room=params.room._replace(**changes))


def _law_off(params: MotionParams) -> MotionParams:
    law = ClearanceLaw(0.01, 0.02, 0.03, *([params.law.speed_mps_max] * 3))
    return msgspec.structs.replace(params, law=law)


def _without_headway(params: MotionParams) -> MotionParams:
    return msgspec.structs.replace(params, speed=msgspec.structs.replace(params.speed, gap_s=0.0))


def _certain(rules: BehaviourRules) -> BehaviourRules:
    return msgspec.structs.replace(rules, inflation_growth=0.0, inflation_m_max=0.0)


def _unhidden(rules: BehaviourRules) -> BehaviourRules:
    return msgspec.structs.replace(rules, hidden_reach_m=0.0)


def _guard(**changes: float) -> Callable[[Car], Car]:
    """A study of what the guard costs. No vehicle is driven like that."""

    def changed(car: Car) -> Car:
        guard = car.guard
        assert isinstance(guard, Guard)
        avoidance = msgspec.structs.replace(guard.avoidance, **changes)
        return dataclasses.replace(car, guard=msgspec.structs.replace(guard, avoidance=avoidance))

    return changed


ALLOWANCES: tuple[Allowance, ...] = (
    Allowance("hard_margin", "hard margin around people: 0", _motion(hard_margin_m=0.0)),
    Allowance("soft_margin", "soft margin around people: 0", _motion(soft_margin_m=0.0)),
    Allowance("inflation", "w_o and the growth of predictions: 0", rules=_certain),
    Allowance("stop_gap", "gap between bumper and what it stops for: 0", _motion(stop_gap_m=0.0)),
    Allowance("hard_headway", "seconds of way kept free for the guard: 0", _motion(gap_s=0.0)),
    Allowance("soft_headway", "seconds of way kept free as a reserve: 0", _without_headway),
    Allowance("early", "nobody comes earlier than predicted", _motion(early_s=0.0)),
    Allowance("clearance_law", "no speed by clearance (eq. 2)", _law_off),
    Allowance("step", "a turn into the way is answered at once", _room(late_s=0.0)),
    Allowance("room", "no room to stop, and nobody turns into the way", _room(aside_m=-1.0)),
    Allowance("hidden", "hidden places do not slow it down", rules=_unhidden),
    Allowance(
        "guard_margins",
        "guard: no margins around the body",
        car=_guard(front_margin_m=0.0, margin_m=0.0),
    ),
    Allowance("guard_release", "guard: the brake is released at once", car=_guard(release_s=0.0)),
    Allowance("tracker_delay", "tracker: no latency", tracker=TrackerNoise(latency_ns=0)),
    Allowance(
        "tracker_noise",
        "tracker: exact",
        tracker=TrackerNoise(
            position_std_m=0.0, velocity_std_mps=0.0, heading_std_rad=0.0, dropout_ratio=0.0
        ),
    ),
)
