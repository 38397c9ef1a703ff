"""The reservation controller of one transaction: rebuilt from the store, and changes are stored at once."""

from collections.abc import Sequence
from dataclasses import replace

from contract.roads.reservation import ReservationError, Reservations
from server.domain.errors import SectionsTaken, VehicleNotPlaced
from server.domain.orders.sections import HeldSection, Occupancy
from server.usecases.ports import topics
from server.usecases.ports.unit_of_work import UnitOfWork


class SectionReservations:
    """Every change of sections goes through this class, so that no section is granted twice."""

    def __init__(self, uow: UnitOfWork) -> None:
        self._uow = uow
        self._occupancies = {occupancy.vehicle_id: occupancy for occupancy in uow.sections.all()}
        self._controller: Reservations = uow.roads().reservations()
        for occupancy in self._occupancies.values():
            self._controller.restore(
                occupancy.vehicle_id, occupancy.held_ids, occupancy.ahead, occupancy.goal
            )

    def occupancy(self, vehicle_id: str) -> Occupancy:
        """Raises VehicleNotPlaced."""
        try:
            return self._occupancies[vehicle_id]
        except KeyError:
            raise VehicleNotPlaced(
                f"the position of {vehicle_id} is not known; let it report one, or place it by hand"
            ) from None

    def held_by_others(self, vehicle_id: str) -> frozenset[str]:
        """Sections that some other vehicle holds."""
        return frozenset(
            section_id
            for other_id, occupancy in self._occupancies.items()
            if other_id != vehicle_id
            for section_id in occupancy.held_ids
        )

    def place(self, vehicle_id: str, section_ids: Sequence[str]) -> Occupancy:
        """Enter a vehicle with the ground under its body. Raises SectionsTaken."""
        try:
            self._controller.place(vehicle_id, section_ids)
        except ReservationError as error:
            raise SectionsTaken(error.detail) from error
        held = tuple(HeldSection(s, self._uow.sections.next_fence()) for s in section_ids)
        return self._store(Occupancy(vehicle_id, held, ()))

    def adopt(self, vehicle_id: str, route: Sequence[str]) -> bool:
        """Make this the vehicle's route, if that is safe. The route begins with what it holds."""
        occupancy = self.occupancy(vehicle_id)
        if not self._controller.adopt(vehicle_id, route):
            return False
        ahead = self._controller.ahead(vehicle_id)
        self._store(Occupancy(vehicle_id, occupancy.held, ahead, route[-1]))
        return True

    def grant(self, vehicle_id: str, count: int) -> int:
        """Grant the longest safe sequence of up to `count` sections. Returns how many were granted."""
        occupancy = self.occupancy(vehicle_id)
        granted = self._controller.grant(vehicle_id, count)
        if granted:
            held = tuple(HeldSection(grant.section_id, self._uow.sections.next_fence()) for grant in granted)
            ahead = self._controller.ahead(vehicle_id)
            self._store(Occupancy(vehicle_id, occupancy.held + held, ahead, occupancy.goal))
        return len(granted)

    def release(self, vehicle_id: str, section_id: str, fence: int) -> bool:
        """Take back a section that the vehicle has left; False for a grant that is no longer in force.

        The last section is kept: every vehicle stands on one.
        """
        occupancy = self._occupancies.get(vehicle_id)
        gone = HeldSection(section_id, fence)
        if occupancy is None or gone not in occupancy.held or len(occupancy.held) == 1:
            return False
        held = tuple(section for section in occupancy.held if section != gone)
        kept = replace(occupancy, held=held)
        self._controller.keep(vehicle_id, kept.held_ids)
        self._store(kept)
        return True

    def remove(self, vehicle_id: str) -> None:
        """The vehicle is off the roads."""
        if vehicle_id in self._occupancies:
            self._controller.remove(vehicle_id)
            del self._occupancies[vehicle_id]
            self._uow.sections.remove(vehicle_id)
            self._uow.publish(topics.sections(self._uow.campus_id))

    def waits_for(self, vehicle_id: str) -> tuple[str, ...]:
        """The vehicles that keep this one from its next section."""
        return self._controller.blocked_by(vehicle_id)

    def _store(self, occupancy: Occupancy) -> Occupancy:
        self._occupancies[occupancy.vehicle_id] = occupancy
        self._uow.sections.save(occupancy)
        self._uow.publish(topics.sections(self._uow.campus_id))
        return occupancy
