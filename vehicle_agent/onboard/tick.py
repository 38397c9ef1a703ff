"""The whole onboard loop, top to bottom, 50 times a second.

Pure: the same state and inputs give the same state and outputs, live, in simulation and in replay.
"""

from vehicle_agent.onboard.car import Car
from vehicle_agent.onboard.report import ages, status, with_faults
from vehicle_agent.onboard.state import OnboardState
from vehicle_agent.signals import Flow, Inputs, Outputs


def tick(state: OnboardState, inputs: Inputs, car: Car) -> tuple[OnboardState, Outputs]:
    """One step of all rooms. `car`: the rooms of a stack (`stacks/`), which never change."""
    now = inputs.stamp_ns
    motion, can = car.can.decode(state.can, inputs.frames, now)
    ego, loc = car.localization.step(state.localization, motion, inputs.navigation, now)
    detections, per = car.perception.step(state.perception, inputs.percepts, ego)
    world, wrl = car.world.step(state.world, ego, detections, inputs.infrastructure, now)
    task, mis = car.mission.step(
        state.mission, inputs.messages, inputs.cabin_events, inputs.link, ego, motion, world, now
    )
    path, pln = car.planning.step(state.planning, ego, world, task, inputs.plans)
    command, ctl = car.control.step(state.control, ego, path, motion)
    judged = with_faults(motion, command, car.perception.faults(per, now))
    actuation, guard_status, grd = car.guard.step(
        state.guard, command, judged, ego, world, task, path, ages(now, motion, ego, detections, path)
    )
    hmi_output, hmi = car.hmi.step(state.hmi, task, path, world, guard_status, now)
    frames, can = car.can.encode(can, actuation, now, hmi_output.signals)
    new = OnboardState(state.tick + 1, can, loc, per, wrl, mis, pln, ctl, grd, hmi)
    events = car.mission.events(mis) + car.guard.events(grd)
    report = status(now, ego, motion, task, path, guard_status, hmi_output)
    flow = Flow(motion, ego, detections, world, task, path, command, actuation, guard_status, hmi_output)
    answers, jobs, asked = car.mission.answers(mis), car.planning.jobs(pln), car.localization.jobs(loc)
    return new, Outputs(frames, hmi_output, events, answers, report, flow, jobs, asked)
