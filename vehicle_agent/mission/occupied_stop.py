"""Waiting short of a stop on which another vehicle stands."""

from vehicle_agent.mission.rules import MissionRules
from vehicle_agent.mission.state import MissionState
from vehicle_agent.signals import Ego, World


def wait_for_occupied_stop(state: MissionState, rules: MissionRules, ego: Ego, world: World) -> MissionState:
    """The state with a place to wait, from when the stop is detected occupied until it is free for a while.

    The place leaves room for a vehicle that stands behind the stop. It is no nearer than the vehicle can stop
    at with comfortable braking. A vehicle that is too near for that drives on; planning stops it for the
    vehicle ahead.
    """
    visit, target_s_m = state.visit_here(), state.target_s_m()
    if visit is None or target_s_m is None or state.stage != "driving":
        return _free(state)
    if visit.stop_id in world.occupied_stops:
        if state.wait_s_m is not None:
            return state.after(stop_free_since_ns=0)
        short_m = target_s_m - rules.body.front_m - rules.body.back_m - rules.occupied_gap_m
        speed_mps = max(0.0, ego.speed_mps)
        stopping_m = speed_mps * rules.hold_reaction_s + speed_mps**2 / (2.0 * rules.hold_decel_mps2)
        wait_s_m = max(short_m, state.s_m + stopping_m)
        return state if wait_s_m >= target_s_m - rules.arrived_m else state.after(wait_s_m=wait_s_m)
    if state.wait_s_m is None:
        return state
    since_ns = state.stop_free_since_ns or state.stamp_ns
    if state.stamp_ns - since_ns >= rules.occupied_clear_ns:
        return _free(state)
    return state.after(stop_free_since_ns=since_ns)


def _free(state: MissionState) -> MissionState:
    if state.wait_s_m is None:
        return state
    return state.after(wait_s_m=None, stop_free_since_ns=0)
