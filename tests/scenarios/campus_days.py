"""A small ring in virtual time, for scenarios: one shuttle, people on foot, rides booked through the API."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

from campusloop.clients.passengers import ENDED, Journey, RideDemand
from campusloop.virtual.campus import CampusOptions, VirtualCampus
from tests.contract.roads.ring_map import ring_map
from tests.faults.real_campus import nearest_pair

STEP_CHECK_S = 0.5


class CampusDay:
    """A started campus and the rides requested on it."""

    def __init__(self, folder: Path, seed: int = 1, vehicles: int = 1, **options: Any) -> None:
        road_map = ring_map()
        self.campus = VirtualCampus(
            CampusOptions(
                road_map, folder, seed, vehicles, database_url=f"sqlite:///{folder / 'campus.db'}", **options
            )
        )
        self.pair = nearest_pair(road_map)
        self.states: list[tuple[int, str]] = []
        self._closed = False
        self.campus.start()
        self.passengers = self.campus.passengers(self._record_state)

    def _record_state(self, journey: Journey) -> None:
        self.states.append((journey.demand.number, journey.state))

    def request_ride(
        self, number: int = 1, party: int = 1, how: Any = "code", turns_up: bool = True
    ) -> Journey:
        """Book a ride now."""
        journey = Journey(RideDemand(number, 0.0, *self.pair, party, how, turns_up))
        self.campus.conductor.loop.create_task(self.passengers.run_journey(journey))
        return journey

    def until(self, condition: Callable[[], bool], timeout_s: float = 1200.0) -> None:
        """Run until the condition holds; fails after timeout_s."""
        assert self.campus.conductor.run_until(condition, timeout_s), (
            f"not within {timeout_s} s: {self.states}"
        )

    def until_state(self, journey: Journey, state: str, timeout_s: float = 1200.0) -> None:
        self.until(lambda: journey.state == state or journey.state in ENDED, timeout_s)
        assert journey.state == state, (journey.state, journey.reason, self.states)

    def close(self) -> None:
        """Finish run logs and server, once."""
        if not self._closed:
            self._closed = True
            self.campus.stop()

    def run_for(self, seconds: float) -> None:
        self.campus.conductor.run_for(seconds)

    def kinds_of_incidents(self) -> list[str]:
        return [incident["kind"] for incident in self.campus.call(self.campus.operator.incidents())]
