"""What passengers ask for on the onboard screen: help, and another destination."""

from contract.wire.messages import DestinationRequested, HelpRequested
from server.domain.errors import DomainError
from server.domain.fleet.vehicles import Vehicle
from server.domain.record.incidents import IncidentKind
from server.domain.rides.rides import RideState
from server.usecases.ports.unit_of_work import Transactions, UnitOfWork
from server.usecases.record.commands import send_command
from server.usecases.record.incidents import open_incident
from server.usecases.record.server_events import THE_SERVER, record_event
from server.usecases.rides.destinations import change_destination

CHANGED = "Your destination is changed. 目的地已更改。"
NOT_CHANGED = "Your destination stays as it was. 目的地未更改。"


def help_requested(uow: UnitOfWork, vehicle: Vehicle, event: HelpRequested) -> None:
    """Open an incident of the highest priority about this vehicle; an open call is kept."""
    vehicle_id = vehicle.vehicle_id
    seat = f" at seat {event.seat}" if event.seat else ""
    cause = f"a passenger{seat} calls for help on board"
    record_event(uow, "vehicle.help_called", vehicle_id, vehicle_id, cause)
    open_incident(uow, IncidentKind.HELP_CALL, vehicle_id, cause, vehicle_id=vehicle_id)


async def answer_destination_request(
    transactions: Transactions, vehicle_id: str, event: DestinationRequested
) -> None:
    """Change the destination of a party aboard, and say in the vehicle whether it was changed.

    In a transaction of its own: a refusal takes back what was tried, but not the event that asked for it.
    """

    def change(uow: UnitOfWork) -> bool:
        ride = uow.rides.get(event.ride_id)
        if ride is None or ride.vehicle_id != vehicle_id or ride.state is not RideState.ABOARD:
            return False
        change_destination(uow, ride, event.stop_id, "passenger")
        send_command(uow, vehicle_id, "announce", THE_SERVER, CHANGED)
        return True

    reason = "the ride is not aboard this shuttle"
    try:
        if await transactions.run(change):
            return
    except DomainError as error:
        reason = error.detail

    def refuse(uow: UnitOfWork) -> None:
        record_event(uow, "vehicle.destination_refused", vehicle_id, vehicle_id, reason)
        send_command(uow, vehicle_id, "announce", THE_SERVER, NOT_CHANGED)

    await transactions.run(refuse)
