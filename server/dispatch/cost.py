"""What a route costs: seconds driven, people's seconds of waiting and riding, and late timetable calls."""

import math
from collections.abc import Mapping, Sequence

from server.dispatch.problem import Call, CostWeights, Request, VehicleState
from server.dispatch.schedule import CallTime


def route_cost(
    vehicle: VehicleState,
    calls: Sequence[Call],
    times: Sequence[CallTime],
    requests: Mapping[str, Request],
    weights: CostWeights,
) -> float:
    """Weighted seconds. Waiting counts from the start of a party's window to its pickup, riding from there
    to its arrival; who is aboard already rides from the snapshot on."""
    drive_s = wait_s = ride_s = late_s = 0.0
    place = vehicle.start
    picked_up = dict.fromkeys(vehicle.aboard, vehicle.ready_s)
    for call, time in zip(calls, times, strict=True):
        drive_s += float(vehicle.times[place, call.place])
        place = call.place
        if math.isfinite(call.leave_from_s):
            late_s += max(0.0, time.leave_s - call.leave_from_s)
        for request_id in call.board:
            request = requests[request_id]
            picked_up[request_id] = max(time.arrive_s, request.pickup_from_s)
            wait_s += request.party * (picked_up[request_id] - request.pickup_from_s)
        for request_id in call.alight:
            ride_s += requests[request_id].party * (time.arrive_s - picked_up[request_id])
    cost = weights.drive * drive_s + weights.wait * wait_s + weights.ride * ride_s
    return cost + weights.late * late_s
