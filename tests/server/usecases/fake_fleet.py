"""Some fake shuttles on one campus, stepped together with the server's standing work."""

from collections.abc import Callable, Sequence
from dataclasses import replace

from contract.roads.model import RoadMap
from contract.roads.network import RoadNetwork
from server.domain.fleet.vehicles import StatusReport
from server.domain.orders.sections import Occupancy
from server.domain.planning.plans import Plan
from server.domain.rides.rides import BookRide, Ride
from server.usecases.fleet import charging, closures, vehicle_sessions
from server.usecases.orders import sections
from server.usecases.planning import earlier_promises, plans, promises
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.rides import lost_vehicles, rides
from tests.server.usecases.campus_under_test import CampusUnderTest
from tests.server.usecases.fake_shuttle import STEP_S, FakeShuttle
from vehicle_agent.mission.order_line import LanePoint


class FakeFleet:
    def __init__(self, campus: CampusUnderTest, road_map: RoadMap, count: int) -> None:
        self.campus = campus
        self.network = RoadNetwork(road_map)
        self.beats = 0
        self.shuttles: list[FakeShuttle] = []
        for number, rest in enumerate(road_map.resting_places[:count]):
            vehicle_id = f"shuttle-{number + 1}"
            campus.enrol(vehicle_id)
            place = LanePoint(rest.lane_id, rest.s_m)
            self.shuttles.append(FakeShuttle(campus, vehicle_id, self.network, place))

    def start(self) -> "FakeFleet":
        for shuttle in self.shuttles:
            shuttle.connect()
            shuttle.resume()
        return self

    def step(self) -> None:
        self.campus.clock.advance(STEP_S)
        for shuttle in self.shuttles:
            shuttle.step()
        reports = [shuttle.status_report() for shuttle in self.shuttles if shuttle.connected]
        self.campus.do(lambda uow: self.beat(uow, reports))

    def beat(self, uow: UnitOfWork, reports: Sequence[StatusReport]) -> None:
        """What the dispatcher does from second to second, in one transaction.

        AssertionError when two shuttles hold the same section or conflicting ones.
        """
        vehicle_sessions.record_status(uow, reports)
        self.beats += 1
        if self.beats % 2 == 0:
            closures.update_closures(uow)
            lost_vehicles.rescue_riders(uow)
            plans.assign_waiting(uow)
            sections.extend_grants(uow)
            promises.check_promises(uow)
        if self.beats % 4 == 0:
            closures.keep_reachable(uow)
            charging.manage_charging(uow)
            earlier_promises.promise_earlier(uow)
        self.require_apart(uow.sections.all())

    def run_until_idle(self, limit_s: float) -> None:
        """AssertionError when a shuttle still has a visit to make after limit_s."""
        self.run_until(
            lambda: not (any(shuttle.next_visit() for shuttle in self.shuttles) or self.waiting()), limit_s
        )

    def run_until(self, condition: Callable[[], bool], limit_s: float = 7200.0) -> None:
        """AssertionError when the condition does not hold after limit_s."""
        waited_s = 0.0
        while not condition():
            assert waited_s < limit_s, self.stuck()
            self.step()
            waited_s += STEP_S

    def waiting(self) -> list[Ride]:
        return [ride for ride in self.rides() if not ride.has_ended]

    def rides(self) -> tuple[Ride, ...]:
        return self.campus.read(lambda uow: uow.views.rides(limit=10_000))

    def book(self, from_stop: str, to_stop: str, party: int = 1, **more: object) -> Ride:
        request = BookRide(from_stop, to_stop, party, **more)  # type: ignore[arg-type]
        return self.campus.do(lambda uow: rides.book(uow, request))

    def ride(self, ride_id: str) -> Ride:
        return self.campus.read(lambda uow: rides.ride_of(uow, ride_id))

    def leave_homeless(self, vehicle_id: str) -> None:
        """Every resting place of the campus belongs to other shuttles from now on."""

        def give_away(uow: UnitOfWork) -> None:
            reserved = {plan.resting_place_id for plan in uow.plans.all() if plan.vehicle_id != vehicle_id}
            plan = plans.plan_of(uow, vehicle_id)
            uow.plans.save(replace(plan, version=plan.version + 1, resting_place_id=""), plan.version)
            for place_id in self.network.resting_places:
                if place_id not in reserved:
                    other = f"shuttle-of-{place_id}"
                    uow.plans.save(Plan(uow.campus_id, other, 1, resting_place_id=place_id), 0)

        for place_id in self.network.resting_places:
            self.campus.enrol(f"shuttle-of-{place_id}")
        self.campus.do(give_away)

    def require_apart(self, occupancies: Sequence[Occupancy]) -> None:
        for number, one in enumerate(occupancies):
            for other in occupancies[number + 1 :]:
                assert not _shadow(self.network, one.held_ids) & set(other.held_ids)

    def stuck(self) -> str:
        return "; ".join(
            f"{s.vehicle_id} at {s.place.lane_id} {s.place.s_m:.1f} m {s.mode} waits for {s.waited_for!r}, "
            f"next {s.next_visit() and s.next_visit().visit_id}"  # type: ignore[union-attr]
            for s in self.shuttles
        )


def _shadow(network: RoadNetwork, held: Sequence[str]) -> set[str]:
    shadow: set[str] = set()
    for section_id in held:
        shadow |= network.shadow(section_id)
    return shadow
