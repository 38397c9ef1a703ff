"""A vehicle's battery as a limit of the dispatcher's problem."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

from contract.geometry import Array
from server.dispatch.problem import Request, VehicleState
from server.domain.fleet.battery import drive_left_s, is_measured
from server.usecases.ports.unit_of_work import UnitOfWork


@dataclass(frozen=True, slots=True)
class ChargeLimits:
    """A battery's level, and whether its vehicle is charging and not full yet."""

    ratio: float
    charging: bool


def within_battery(
    uow: UnitOfWork,
    vehicle: VehicleState,
    charge: ChargeLimits,
    requests: Mapping[str, Request],
    times: Array,
) -> VehicleState:
    """The vehicle with the driving that its battery allows above the reserve, the way to a charger kept."""
    if not is_measured(charge.ratio):
        return vehicle
    legs = _legs(vehicle, requests, times)
    home_s = uow.roads().to_charger_s()
    left_s = drive_left_s(charge.ratio, legs, home_s, uow.rules, charging=charge.charging)
    return replace(vehicle, drive_s_max=left_s)


def _legs(
    vehicle: VehicleState, requests: Mapping[str, Request], times: Array
) -> Iterator[tuple[float, float]]:
    """Seconds driven to each call, and those that the vehicle stands idle before it can begin there."""
    row, clock_s = vehicle.to_places_s, vehicle.ready_s
    for call in vehicle.calls:
        drive_s = float(row[call.place])
        opens_s = max((requests[ride_id].pickup_from_s for ride_id in call.board), default=clock_s)
        opens_s = max(opens_s, call.leave_from_s - call.dwell_s)
        idle_s = max(0.0, opens_s - clock_s - drive_s)
        yield drive_s, idle_s
        clock_s += drive_s + idle_s + call.dwell_s
        row = times[call.place]
