"""What passengers hold: links and boarding codes, derived from the server's ticket keys."""

from dataclasses import replace

from server.domain.errors import RideUnknown, SeriesUnknown, TicketKeyMissing
from server.domain.rides.rides import ENDED, Ride, RideState
from server.domain.rides.series import Series, SeriesState
from server.domain.rides.ticket_keys import RideSecrets, subject_of
from server.usecases.orders import orders
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record.identity import sha256_of
from server.usecases.record.server_events import THE_SERVER, record_event

_OPEN = tuple(state for state in RideState if state not in ENDED)


def secrets_of(uow: UnitOfWork, ride: Ride) -> RideSecrets:
    return uow.tickets.ride_secrets(ride.ticket_key_id, ride.ride_id)


def ride_by_token(uow: UnitOfWork, token: str) -> Ride:
    """Raises RideUnknown."""
    ride = uow.rides.get(subject_of(token))
    if ride is None or not uow.tickets.proves_ride(token, ride.ticket_key_id, ride.ride_id):
        ride = uow.rides.by_old_token(sha256_of(token))
    if ride is None:
        raise RideUnknown("this link belongs to no ride")
    return ride


def series_token(uow: UnitOfWork, series: Series) -> str:
    return uow.tickets.series_token(series.ticket_key_id, series.series_id)


def series_by_token(uow: UnitOfWork, token: str) -> Series:
    """Raises SeriesUnknown."""
    found = uow.series.get(subject_of(token))
    if found is None or not uow.tickets.proves_series(token, found.ticket_key_id, found.series_id):
        found = uow.series.by_old_token(sha256_of(token))
    if found is None:
        raise SeriesUnknown("this link belongs to no recurring booking")
    return found


def take_over_keys(uow: UnitOfWork) -> None:
    """At the start of a server: check that its keys are the campus's, and note a new one.

    Rides of before there were keys get the newest one: their links stay, and shuttles are told the new
    codes. Raises TicketKeyMissing.
    """
    _require_keys(uow)
    newest = uow.tickets.newest_id
    if newest not in uow.identity.ticket_key_ids():
        uow.identity.add_ticket_key(newest, uow.now)
        record_event(uow, "ticket_key.added", newest, THE_SERVER)
    uow.rides.adopt_ticket_key(newest)
    for series in uow.series.listed():
        if not series.ticket_key_id:
            uow.series.save(replace(series, ticket_key_id=newest))
    without = [ride for ride in uow.rides.in_states(_OPEN) if not ride.ticket_key_id]
    for ride in without:
        uow.rides.save(replace(ride, ticket_key_id=newest))
    for vehicle_id in sorted({ride.vehicle_id for ride in without if ride.vehicle_id is not None}):
        orders.repeat(uow, vehicle_id)


def _require_keys(uow: UnitOfWork) -> None:
    known = uow.identity.ticket_key_ids()
    if known and not set(known) & set(uow.tickets.ids):
        raise TicketKeyMissing(
            f"the links of this campus were made with other ticket keys ({', '.join(known)}) than this "
            f"server's ({', '.join(uow.tickets.ids)}); give it a copy of the file of the other servers"
        )
    used = {ride.ticket_key_id for ride in uow.rides.in_states(_OPEN)}
    used |= {series.ticket_key_id for series in uow.series.listed([SeriesState.ACTIVE])}
    missing = sorted(used - {"", *uow.tickets.ids})
    if missing:
        raise TicketKeyMissing(
            f"open rides or recurring bookings have links made with the ticket key {', '.join(missing)}, "
            "which is not in this server's key file; put it back until they have ended"
        )
