"""Ratings and lost property, as passengers tell them after a ride."""

from server.domain.errors import RideNotCompleted
from server.domain.rides.feedback import Feedback
from server.domain.rides.rides import Ride
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record.server_events import record_event


def give_feedback(uow: UnitOfWork, ride: Ride, rating: int | None, lost_property: str) -> Feedback:
    """Replaces what was told before. Raises RideNotCompleted for a ride that nobody has taken, or not yet."""
    if not ride.has_ended or ride.boarded_at is None:
        raise RideNotCompleted("only a ride that was taken can be rated, after its end")
    told = Feedback(uow.campus_id, ride.ride_id, rating, lost_property, uow.now)
    uow.rides.save_feedback(told)
    parts = ["" if rating is None else f"rated {rating} of 5", "lost property" if lost_property else ""]
    # The words stay in one place, from which they are erased with the rider's data.
    record_event(uow, "ride.feedback", ride.ride_id, "passenger", ", ".join(filter(None, parts)))
    return told
