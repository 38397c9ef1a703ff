"""Takes out of the record what names a rider: at an operator's word, and by itself when it is old.

A ride keeps its id, stops, times, party and outcome: the history can be counted, and tells of no person. What
goes: the code that is said aloud, the link, the booking's key, the series that ties rides together, and what
the rider said or others wrote about the ride.
"""

from dataclasses import replace
from datetime import timedelta

from server.domain.record.incidents import ERASED_CAUSE
from server.domain.rides.rides import Ride, erased
from server.domain.rides.series import SeriesState
from server.usecases.ports import topics
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record.identity import sha256_of
from server.usecases.record.server_events import THE_SERVER, record_event
from server.usecases.rides import rides, series
from server.usecases.rides.tickets import secrets_of

# Of one transaction: others wait for it.
TOGETHER_MAX = 200


def erase_ride(uow: UnitOfWork, ride_id: str, by: str) -> Ride:
    """Erase who rode. A repeat changes nothing. Raises RideUnknown, RideNotEnded."""
    ride = rides.ride_of(uow, ride_id)
    gone = _erase(uow, [ride])[0]
    record_event(uow, "ride.erased", ride_id, by)
    uow.publish(topics.ride(uow.campus_id, ride_id), state=str(ride.state))
    return gone


def erase_series(uow: UnitOfWork, series_id: str, by: str) -> int:
    """Erase a recurring booking with its days and who rode; how many rides there were.

    It is cancelled first. Raises SeriesUnknown, RideNotEnded (a ride of it is under way).
    """
    if series.series_of(uow, series_id).state is SeriesState.ACTIVE:
        series.cancel_series(uow, series_id, by)
    found = _rides_of(uow, series_id)
    _erase(uow, found)
    uow.series.erase(series_id)
    record_event(uow, "series.erased", series_id, by, f"{len(found)} rides")
    uow.publish(topics.series(uow.campus_id, series_id))
    return len(found)


def due(uow: UnitOfWork) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Rides that still name their riders `rider_days` after their end, and series that ended then; by id."""
    oldest = uow.now - timedelta(days=uow.rules.rider_days)
    return uow.rides.named_before(oldest, TOGETHER_MAX), uow.series.ended_before(oldest, TOGETHER_MAX)


def erase_due(uow: UnitOfWork, ride_ids: tuple[str, ...], series_ids: tuple[str, ...]) -> None:
    """Erase what is due, with one event for all."""
    for series_id in series_ids:
        uow.series.erase(series_id)
    found = [ride for ride in (uow.rides.get(ride_id) for ride_id in ride_ids) if ride is not None]
    _erase(uow, found)
    detail = (
        f"{len(found)} rides and {len(series_ids)} recurring bookings after {uow.rules.rider_days:g} days"
    )
    record_event(uow, "riders.erased", uow.campus_id, THE_SERVER, detail)


def _rides_of(uow: UnitOfWork, series_id: str) -> list[Ride]:
    days = uow.series.occurrences(series_id)
    booked = (uow.rides.get(day.ride_id) for day in days if day.ride_id is not None)
    return [ride for ride in booked if ride is not None]


def _erase(uow: UnitOfWork, found: list[Ride]) -> list[Ride]:
    """Raises RideNotEnded."""
    gone = [erased(ride) for ride in found]
    ride_ids = [ride.ride_id for ride in found]
    uow.answers.forget_accounts([f"passenger:{sha256_of(secrets_of(uow, ride).token)}" for ride in found])
    uow.rides.erase(gone)
    uow.push_subscriptions.remove_of_rides(ride_ids)
    uow.series.unlink_rides(ride_ids)
    incidents = uow.incidents.about_rides(ride_ids)
    for incident in incidents:
        uow.incidents.save(replace(incident, cause=ERASED_CAUSE))
    uow.events.erase_details([*ride_ids, *(incident.incident_id for incident in incidents)])
    return gone
