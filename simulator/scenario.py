"""Interventions in a world, from a scenario or from control messages."""

from dataclasses import dataclass

from simulator.control import (
    ByWireFault,
    ByWireFlag,
    DriverActs,
    FramesLost,
    GnssOutage,
    Intervention,
    PersonPlaced,
    SeatPressed,
    SteeringStuck,
    StopButton,
)
from simulator.ecus.by_wire import ByWire
from simulator.ecus.injected_flags import UnknownFlagError
from simulator.ecus.module import Module
from simulator.ecus.safety_driver import SafetyDriver
from simulator.world import SimWorld, WorldError


def intervene(world: SimWorld, intervention: Intervention, now_ns: int) -> None:
    """Execute an intervention.

    KeyError for an unknown vehicle; WorldError for a person without traffic and for a flag that the vehicle's
    by-wire module does not have.
    """
    match intervention:
        case SeatPressed(vehicle_id, seat):
            world.riders.press_seat_button(vehicle_id, seat, now_ns)
        case DriverActs(vehicle_id, brake_ratio, throttle_ratio, steer_rad):
            world.module(vehicle_id).driver = SafetyDriver(brake_ratio, throttle_ratio, steer_rad)
        case StopButton(vehicle_id, pressed):
            world.module(vehicle_id).stop_pressed = pressed
        case GnssOutage(vehicle_id, silent):
            world.gnss[vehicle_id].silent = silent
        case ByWireFault(vehicle_id, present):
            world.module(vehicle_id).injected_fault = present
        case ByWireFlag(vehicle_id, report, flag, reports):
            _inject(world.module(vehicle_id), report, flag, reports)
        case SteeringStuck(vehicle_id, stuck):
            world.module(vehicle_id).steering_stuck = stuck
        case FramesLost(vehicle_id, to_module, to_vehicle):
            faults = world.bus_faults(vehicle_id)
            faults.loses_to_module, faults.loses_to_vehicle = to_module, to_vehicle
        case PersonPlaced(x_m, y_m, waypoints):
            if world.pedestrians is None:
                raise WorldError("this world has no pedestrians; give it TrafficParams to place a person")
            world.pedestrians.population.place(x_m, y_m, waypoints)


def _inject(module: Module, report: str, flag: str, reports: int | None) -> None:
    if not isinstance(module, ByWire):
        raise WorldError("flags can be injected into a PACMod module; this vehicle has servos")
    try:
        if reports == 0:
            module.clear_injected(report, flag)
        else:
            module.inject(report, flag, reports)
    except UnknownFlagError as error:
        raise WorldError(str(error)) from error


@dataclass(frozen=True, slots=True)
class ScenarioEvent:
    """at_ns: on the world's clock."""

    at_ns: int
    intervention: Intervention


class Scenario:
    """Executes events in order of time; those of one time in the given order."""

    def __init__(self, events: tuple[ScenarioEvent, ...]) -> None:
        self._ahead = sorted(events, key=lambda event: event.at_ns)

    @property
    def is_over(self) -> bool:
        return not self._ahead

    def step(self, world: SimWorld, now_ns: int) -> None:
        """Execute the events due by now_ns; call it before the world's step."""
        while self._ahead and self._ahead[0].at_ns <= now_ns:
            intervene(world, self._ahead.pop(0).intervention, now_ns)
