import msgspec

from tests.contract.roads.ring_map import ring_map
from vehicle_agent.config import Profile
from vehicle_agent.onboard.car import initial_state
from vehicle_agent.onboard.report import ages
from vehicle_agent.onboard.tick import tick
from vehicle_agent.signals import Inputs
from vehicle_agent.stacks.gem import gem


def test_a_report_that_came_after_the_ticks_stamp_is_new_and_not_missing() -> None:
    car = gem(Profile(), ring_map())
    _, outputs = tick(initial_state(car), Inputs(1_000), car)
    flow = outputs.flow
    newer = msgspec.structs.replace(flow.motion, stamp_ns=1_300)
    assert ages(1_000, flow.motion, flow.ego, flow.detections, flow.path).motion_ns == -1
    assert ages(1_000, newer, flow.ego, flow.detections, flow.path).motion_ns == 0
    assert ages(2_000, newer, flow.ego, flow.detections, flow.path).motion_ns == 700
