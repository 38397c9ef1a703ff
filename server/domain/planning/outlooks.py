"""What the present plan means for one party that waits or rides."""

from dataclasses import dataclass

from server.domain.planning.eta_ranges import ExpectedRange


@dataclass(frozen=True, slots=True)
class RideOutlook:
    """pickup      None for a party that is not waiting, or while no time can be promised
    arrival     None for a party that is not aboard, or while no time can be told
    seats_left  free seats beside the party, on the fullest part of its ride; None while not known
    vehicle_name  of the shuttle that has or had the ride, "" for none
    """

    pickup: ExpectedRange | None = None
    seats_left: int | None = None
    vehicle_name: str = ""
    arrival: ExpectedRange | None = None


NO_OUTLOOK = RideOutlook()
