"""The facts that the store knows at the end, for the rules of the history."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from sqlalchemy import Connection, Engine, select

from campusloop.simulation.history.records import StoredRide
from server.domain.instants import ns_of
from server.domain.orders.orders import OrderState
from server.domain.rides.rides import Ride, RideState
from server.store import tables
from server.store.unit_of_work import Context, SqlUnitOfWork


@dataclass(frozen=True, slots=True)
class StoreFacts:
    """events: (vehicle, boot), then number. planned: rides by vehicle. key_of_ride: of rides with a key.

    numbers    of the stored events by (vehicle, boot), one for each time that it is stored
    held       section and fence of every grant, by vehicle
    connected  vehicles that have a session, as the store knows it
    """

    rides: tuple[StoredRide, ...]
    key_of_ride: Mapping[str, str]
    events: Mapping[tuple[str, str], Mapping[int, str]]
    numbers: Mapping[tuple[str, str], Sequence[int]]
    planned: Mapping[str, tuple[str, ...]]
    open_orders: Mapping[str, frozenset[str]]
    held: Mapping[str, frozenset[tuple[str, int]]]
    connected: frozenset[str]


def store_facts(
    engine: Engine, context: Context, now_s: float, faults_end_s: float, *, clock_was_wrong: bool
) -> StoreFacts:
    """Read without a server: the database is as the last process left it."""
    wall_ns = ns_of(context.clock.now())

    def stored(ride: Ride) -> StoredRide:
        # The first promise counts: a ride that is told ever later times is forgotten all the same. Parties
        # that wait, and were told a later time because the clock was wrong, wait for that time.
        keeps_first = not clock_was_wrong or ride.state is RideState.ABOARD
        promise = (ride.first_promise if keeps_first else None) or ride.promise
        due = ride.earliest if promise is None else promise.arrive_by
        due_s = now_s + (ns_of(due) - wall_ns) * 1e-9
        return StoredRide(
            ride.ride_id,
            str(ride.state),
            ride.has_ended,
            ride.reason,
            ride.vehicle_id,
            ride.party,
            max(due_s, faults_end_s),
        )

    with engine.connect() as connection:
        uow = SqlUnitOfWork(connection, context)
        rides = uow.rides.in_states(list(RideState))
        events: dict[tuple[str, str], dict[int, str]] = {}
        numbers: dict[tuple[str, str], list[int]] = {}
        columns = tables.vehicle_events.c
        for row in connection.execute(
            select(columns.vehicle_id, columns.boot_id, columns.sequence, columns.body)
        ):
            events.setdefault((row.vehicle_id, row.boot_id), {})[row.sequence] = row.body
            numbers.setdefault((row.vehicle_id, row.boot_id), []).append(row.sequence)
        return StoreFacts(
            tuple(stored(ride) for ride in rides),
            {ride.ride_id: ride.idempotency_key for ride in rides if ride.idempotency_key},
            events,
            numbers,
            {plan.vehicle_id: plan.ride_ids for plan in uow.plans.all()},
            _open_orders(connection),
            {
                taken.vehicle_id: frozenset((grant.section_id, grant.fence) for grant in taken.held)
                for taken in uow.sections.all()
            },
            frozenset(vehicle.vehicle_id for vehicle in uow.vehicles.all() if vehicle.connected),
        )


def _open_orders(connection: Connection) -> dict[str, frozenset[str]]:
    """The orders in force, by vehicle: those whose newest revision is not done."""
    order = tables.orders.c
    rows = connection.execute(
        select(order.vehicle_id, order.order_id, order.state).order_by(order.order_id, order.revision)
    )
    newest = {(row.vehicle_id, row.order_id): row.state for row in rows}
    found: dict[str, frozenset[str]] = {}
    for (vehicle_id, order_id), state in newest.items():
        if state != OrderState.DONE:
            found[vehicle_id] = found.get(vehicle_id, frozenset()) | {order_id}
    return found
