"""The verdict at the end of a run: every rule of the history over what was observed and what is stored."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

from campusloop.simulation.history import rides, vehicles
from campusloop.simulation.history.records import TaskFact, VehicleFact, Violation
from campusloop.simulation.observation import Observation
from campusloop.simulation.process.service_process import Machine, ServiceProcess
from campusloop.simulation.process.store_facts import StoreFacts


@dataclass(frozen=True, slots=True)
class CheckedState:
    """What was true minutes before the end, so that nothing of it may still be under way at the end.

    left     grants that each vehicle had left
    durable  events on vehicles' disks, as in `Observation`; seen: what vehicles saw of rides
    """

    left: Mapping[str, Collection[tuple[str, int]]]
    durable: Mapping[tuple[str, str], Mapping[int, str]]
    seen: Sequence[VehicleFact]


def judge(
    observation: Observation,
    facts: StoreFacts,
    service: ServiceProcess | None,
    machine: Machine,
    fleet: Sequence[str],
    commands: Mapping[str, str],
    at_check: CheckedState,
    bound_s: float,
) -> list[Violation]:
    """What `judge_history` finds, and what is wrong with the process that runs at the end."""
    at_s = observation.now_s()
    found = judge_history(observation, facts, fleet, commands, at_check, bound_s)
    if service is None or service.is_over:
        return [*found, Violation(at_s, "task_dead", "server", "no server runs at the end")]
    connected = service.services.hub.connected()
    found += [
        Violation(at_s, "vehicle_unreachable", name, "has no session at the end")
        for name in fleet
        if name not in connected
    ]
    found += [
        Violation(at_s, "vehicle_unreachable", name, "has a session, but the store counts it as gone")
        for name in fleet
        if name in connected and name not in facts.connected
    ]
    return [*found, *vehicles.dead_tasks(at_s, _tasks(service, machine))]


def judge_history(
    observation: Observation,
    facts: StoreFacts,
    fleet: Sequence[str],
    commands: Mapping[str, str],
    at_check: CheckedState,
    bound_s: float,
) -> list[Violation]:
    """commands: the last check's, by vehicle. bound_s: how long after it is due a ride may still go on."""
    at_s, booked = observation.now_s(), observation.acknowledged
    found = [
        *rides.lost_bookings(at_s, booked, {ride.ride_id for ride in facts.rides}),
        *rides.doubled_bookings(at_s, booked),
        *rides.doubled_keys(at_s, facts.key_of_ride),
        *rides.forgotten_riders(at_s, facts.rides, bound_s),
        *rides.untrue_rides(at_s, facts.rides, observation.seen),
        *rides.unreported_rides(at_s, facts.rides, at_check.seen),
        *rides.planned_twice(at_s, facts.planned),
        *vehicles.several_orders(at_s, facts.open_orders),
    ]
    for (vehicle_id, boot_id), durable in at_check.durable.items():
        stored = facts.events.get((vehicle_id, boot_id), {})
        found += vehicles.lost_events(at_s, vehicle_id, boot_id, durable, stored)
    for (vehicle_id, boot_id), numbers in facts.numbers.items():
        found += vehicles.doubled_events(at_s, vehicle_id, boot_id, numbers)
    for vehicle_id, held in facts.held.items():
        found += vehicles.leaked_sections(at_s, vehicle_id, held, at_check.left.get(vehicle_id, ()))
    reached = {vehicle_id for vehicle_id, command in commands.items() if command in observation.done}
    return [*found, *vehicles.unreachable(at_s, fleet, reached)]


def _tasks(service: ServiceProcess, machine: Machine) -> list[TaskFact]:
    now = machine.clock.now()
    running = {task.get_name() for task in service.running_tasks()}
    return [
        TaskFact(
            health.name,
            health.name in running,
            health.failures,
            None
            if health.period_s is None
            else (now - (health.last_good_at or health.started_at)).total_seconds(),
            health.period_s or 0.0,
        )
        for health in service.services.supervisor.health()
    ]
