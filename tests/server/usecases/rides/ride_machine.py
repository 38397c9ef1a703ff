"""Every ride state against every event, in any order: nobody's ride is ever lost.

A machine of rules that passengers, operators, vehicles and clocks play at random. After each of them every
ride is final, waits for a vehicle, or is in the plan of the vehicle that has it; at the end, when everything
works again, every ride reaches a final state.
"""

from collections.abc import Callable
from datetime import timedelta
from typing import Any

from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, rule
from sqlalchemy import Engine

from contract.wire.messages import (
    OrderRejected,
    RiderAlighted,
    RiderBoarded,
    RiderDidNotAlight,
    RiderNoShow,
    RiderTask,
    SeatButtonPressed,
    VehicleEvent,
    VisitChanged,
)
from contract.wire.sequence import SequenceGap
from server.domain.errors import DomainError, SessionFenced
from server.domain.instants import ns_of
from server.domain.orders.orders import OrderState
from server.domain.record.events import RecordedEvent
from server.domain.rides.effects import Intervention
from server.domain.rides.rides import Ride, RideState
from server.usecases.fleet import (
    events,
    interventions,
    vehicle_sessions,
    vehicles,
)
from server.usecases.orders import orders
from server.usecases.rides import destinations, lost_vehicles, rides
from tests.server.usecases.campus_under_test import CampusUnderTest
from tests.server.usecases.fake_fleet import FakeFleet
from tests.server.usecases.fake_shuttle import FakeShuttle
from tests.server.usecases.fresh_database import fresh_database
from tests.server.usecases.small_campus import small_campus

STOPS = tuple(f"stop-{number}" for number in range(4))
SHUTTLES = st.integers(0, 1)
SPEED_MPS = 8.0
SETTLED_WITHIN_STEPS = 900
IDLE_S = 60.0


class RideMachine(RuleBasedStateMachine):
    """new_database: an empty one with all tables, for every story."""

    new_database: Callable[[], Engine] = staticmethod(fresh_database)

    @initialize()
    def start(self) -> None:
        road_map = small_campus()
        self.campus = CampusUnderTest(road_map, engine=self.new_database())
        self.fleet = FakeFleet(self.campus, road_map, 2)
        for shuttle in self.fleet.shuttles:
            shuttle.speed_mps = SPEED_MPS
        self.fleet.start()
        self.boots = 1
        self.retired: set[str] = set()
        self.book("stop-0", 2, 2, 0.0, None)
        self.book("stop-1", 2, 1, 0.0, None)
        self.drive(4)

    # ------------------------------------------------------------ who may do something, about equally often

    @rule(
        origin=st.sampled_from(STOPS),
        onward=st.integers(1, 3),
        party=st.integers(1, 4),
        ahead_s=st.sampled_from([0.0, 0.0, 600.0]),
        key=st.sampled_from([None, None, "key-one", "key-two"]),
    )
    def somebody_books(self, origin: str, onward: int, party: int, ahead_s: float, key: str | None) -> None:
        self.book(origin, onward, party, ahead_s, key)

    @rule(steps=st.integers(1, 12))
    def the_fleet_drives(self, steps: int) -> None:
        self.drive(steps)

    @rule(steps=st.integers(12, 30))
    def the_fleet_drives_on(self, steps: int) -> None:
        self.drive(steps)

    @rule(data=st.data(), number=st.integers(0, 9))
    def a_passenger_acts(self, data: st.DataObject, number: int) -> None:
        match data.draw(st.sampled_from(["cancel", "redirect", "redirect", "tap", "stay away"])):
            case "cancel":
                self.cancel(number, data.draw(st.sampled_from(["passenger", "operator"])))
            case "redirect":
                self.change_destination(number, data.draw(st.sampled_from(STOPS)))
            case "tap":
                self.tap(number, data.draw(st.sampled_from(["board", "alight"])))
            case _:
                self.stay_away(number)

    @rule(data=st.data(), which=SHUTTLES)
    def a_rider_acts(self, data: st.DataObject, which: int) -> None:
        match data.draw(st.sampled_from(["button", "get off", "stay"])):
            case "button":
                self.press_the_seat_button(which, data.draw(st.booleans()))
            case "get off":
                self.get_off_early(which)
            case _:
                self.stay_seated(which)

    @rule(data=st.data(), which=SHUTTLES, number=st.integers(0, 9))
    def a_vehicle_errs(self, data: st.DataObject, which: int, number: int) -> None:
        match data.draw(st.sampled_from(["skip", "refuse", "untrue"])):
            case "skip":
                self.skip_a_visit(which)
            case "refuse":
                codes = ["unreachable", "visit_under_way", "map_version", "expired"]
                self.refuse_the_order(which, data.draw(st.sampled_from(codes)))
            case _:
                words = [RiderBoarded, RiderAlighted, RiderNoShow, RiderDidNotAlight]
                self.say_something_untrue(which, number, data.draw(st.sampled_from(words)))

    @rule(data=st.data(), which=SHUTTLES)
    def a_link_fails(self, data: st.DataObject, which: int) -> None:
        match data.draw(st.sampled_from(["lose", "lose", "find", "boot", "repeat", "gap", "old"])):
            case "lose":
                self.lose(which)
            case "find":
                self.find_again(which)
            case "boot":
                self.boot_anew(which)
            case "repeat":
                self.repeat_an_event(which, data.draw(st.integers(1, 5)))
            case "gap":
                self.leave_a_gap(which)
            case _:
                self.speak_with_an_old_session(which)

    @rule(data=st.data(), which=SHUTTLES)
    def an_operator_acts(self, data: st.DataObject, which: int) -> None:
        match data.draw(st.sampled_from(["retire", "recall", "evacuate", "hold", "reassign"])):
            case "retire" if not self.retired:
                self.retire()
            case "evacuate":
                self.evacuate(which)
            case "hold":
                self.hold(which, data.draw(st.sampled_from([None, 60.0, 900.0])))
            case "reassign":
                self.intervene(which, Intervention("reassign"))
            case _:
                self.recall_and_return(which)

    @rule(seconds=st.sampled_from([-5.0, 90.0, 600.0, 7200.0]))
    def the_clock_jumps(self, seconds: float) -> None:
        self.campus.clock.advance(seconds)

    # ------------------------------------------------------------ people

    def book(self, origin: str, onward: int, party: int, ahead_s: float, key: str | None) -> None:
        to_stop = STOPS[(STOPS.index(origin) + onward) % len(STOPS)]
        earliest = self.campus.clock.now() + timedelta(seconds=ahead_s)
        self.try_(lambda: self.fleet.book(origin, to_stop, party, earliest=earliest, idempotency_key=key))

    def cancel(self, number: int, by: str) -> None:
        ride = self.some_ride(number)
        if ride is not None:
            self.try_(lambda: self.campus.do(lambda uow: rides.cancel(uow, ride.ride_id, by)))

    def change_destination(self, number: int, to_stop: str) -> None:
        ride = self.some_ride(number)
        if ride is not None:
            self.try_(
                lambda: self.campus.do(
                    lambda uow: destinations.change_destination(
                        uow, rides.ride_of(uow, ride.ride_id), to_stop, "passenger"
                    )
                )
            )

    def tap(self, number: int, kind: Any) -> None:
        ride = self.some_ride(number)
        if ride is not None:
            self.try_(lambda: self.campus.do(lambda uow: rides.tap(uow, ride.ride_id, kind)))

    def stay_away(self, number: int) -> None:
        ride = self.some_ride(number)
        if ride is not None:
            for shuttle in self.fleet.shuttles:
                shuttle.no_shows.add(ride.ride_id)

    # ------------------------------------------------------------ vehicles

    def drive(self, steps: int) -> None:
        for _ in range(steps):
            self.fleet.step()

    def press_the_seat_button(self, which: int, accepted: bool) -> None:
        shuttle = self.fleet.shuttles[which]
        place = shuttle.place
        reason = "" if accepted else "no place to stop lies before the next stop"
        shuttle.say(SeatButtonPressed(1, accepted, "temporary-1", place.lane_id, place.s_m, reason))

    def get_off_early(self, which: int) -> None:
        shuttle = self.fleet.shuttles[which]
        for ride_id in list(shuttle.aboard)[:1]:
            del shuttle.aboard[ride_id]
            shuttle.say(RiderAlighted(ride_id, "sensor"))

    def stay_seated(self, which: int) -> None:
        shuttle = self.fleet.shuttles[which]
        for ride_id in list(shuttle.aboard)[:1]:
            shuttle.say(RiderDidNotAlight(ride_id))

    def say_something_untrue(self, which: int, number: int, kind: Any) -> None:
        """About any ride, even one that another vehicle has. What it says is what it then believes."""
        ride, shuttle = self.some_ride(number), self.fleet.shuttles[which]
        if ride is None or shuttle.vehicle_id in self.retired:
            return
        if kind is RiderBoarded:
            elsewhere = any(ride.ride_id in other.aboard for other in self.fleet.shuttles)
            seated = sum(rider.party for rider in shuttle.aboard.values())
            if elsewhere or ride.state in (RideState.COMPLETED, RideState.FAILED, RideState.REFUSED):
                return
            if seated + ride.party > shuttle.seats:
                return
            shuttle.aboard[ride.ride_id] = RiderTask(ride.ride_id, ride.party)
            shuttle.say(RiderBoarded(ride.ride_id, "sensor"))
        elif kind is RiderAlighted:
            shuttle.aboard.pop(ride.ride_id, None)
            shuttle.say(RiderAlighted(ride.ride_id, "sensor"))
        elif ride.ride_id not in shuttle.aboard:
            shuttle.say(kind(ride.ride_id))

    def skip_a_visit(self, which: int) -> None:
        shuttle = self.fleet.shuttles[which]
        visit = shuttle.next_visit()
        if visit is not None and visit.kind == "stop" and shuttle.states[visit.visit_id] == "pending":
            shuttle.states[visit.visit_id] = "skipped"
            shuttle.say(VisitChanged(visit.visit_id, visit.stop_id, "skipped"))

    def refuse_the_order(self, which: int, code: Any) -> None:
        shuttle = self.fleet.shuttles[which]
        order = self.campus.read(lambda uow: uow.orders.current(shuttle.vehicle_id))
        if order is not None and order.state is OrderState.ISSUED:
            answer = OrderRejected(shuttle.epoch, order.order_id, order.revision, code, "test")
            self.try_(lambda: self.campus.do(lambda uow: orders.rejected(uow, shuttle.vehicle_id, answer)))

    # ------------------------------------------------------------ links, boots and clocks

    def lose(self, which: int) -> None:
        shuttle = self.fleet.shuttles[which]
        if shuttle.connected:
            shuttle.disconnect()

    def find_again(self, which: int) -> None:
        if self.fleet.shuttles[which].vehicle_id not in self.retired:
            self.fleet.shuttles[which].recover()

    def boot_anew(self, which: int) -> None:
        """What the old boot had not told yet comes late, under its old name."""
        shuttle = self.fleet.shuttles[which]
        if shuttle.vehicle_id in self.retired:
            return
        old_boot, waiting = shuttle.boot_id, shuttle.told[shuttle.sequence :]
        first = shuttle.sequence
        self.boots += 1
        shuttle.boot_id, shuttle.told, shuttle.sequence = f"boot-{self.boots}", [], 0
        shuttle.mode = "held"
        shuttle.connect()
        for sequence, body in enumerate(waiting, start=first):
            self.send(shuttle, old_boot, sequence, body)

    def repeat_an_event(self, which: int, back: int) -> None:
        shuttle = self.fleet.shuttles[which]
        if shuttle.sequence >= back:
            before = self.campus.read(lambda uow: uow.views.rides())
            assert not shuttle.send(shuttle.sequence - back).is_new
            assert self.campus.read(lambda uow: uow.views.rides()) == before

    def leave_a_gap(self, which: int) -> None:
        shuttle = self.fleet.shuttles[which]
        body = RiderNoShow("ride-1")
        try:
            self.send(shuttle, shuttle.boot_id, shuttle.sequence + 3, body)
        except SequenceGap:
            return
        raise AssertionError("an event after a gap was taken")

    def speak_with_an_old_session(self, which: int) -> None:
        shuttle = self.fleet.shuttles[which]
        try:
            self.campus.read(
                lambda uow: vehicle_sessions.require_epoch(uow, shuttle.vehicle_id, shuttle.epoch - 1)
            )
        except SessionFenced:
            return
        raise AssertionError("an old session was heard")

    def recall_and_return(self, which: int) -> None:
        vehicle_id = self.fleet.shuttles[which].vehicle_id
        self.try_(lambda: self.campus.do(lambda uow: vehicles.recall(uow, vehicle_id, "ann")))
        if vehicle_id not in self.retired:
            self.campus.do(lambda uow: vehicles.return_to_service(uow, vehicle_id, "ann"))

    def evacuate(self, which: int) -> None:
        """Whoever is told to leaves without a word to the vehicle."""
        shuttle = self.fleet.shuttles[which]
        self.try_(lambda: self.campus.do(lambda uow: lost_vehicles.evacuate(uow, shuttle.vehicle_id, "ann")))
        for ride_id in list(shuttle.aboard):
            if self.fleet.ride(ride_id).state is not RideState.ABOARD:
                del shuttle.aboard[ride_id]

    def hold(self, which: int, for_s: float | None) -> None:
        shuttle = self.fleet.shuttles[which]
        if shuttle.vehicle_id not in self.retired:
            self.intervene(which, Intervention("hold", for_s))
            shuttle.hold()

    def intervene(self, which: int, wish: Intervention) -> None:
        vehicle_id = self.fleet.shuttles[which].vehicle_id
        self.try_(lambda: self.campus.do(lambda uow: interventions.intervene(uow, vehicle_id, wish, "ann")))

    def retire(self) -> None:
        """Only one of the two, so that somebody is left to bring everybody home."""
        shuttle = self.fleet.shuttles[1]
        self.campus.do(lambda uow: vehicles.retire(uow, shuttle.vehicle_id, "ann"))
        shuttle.connected, shuttle.order, shuttle.mode = False, None, "held"
        shuttle.aboard.clear()
        self.retired.add(shuttle.vehicle_id)

    # ------------------------------------------------------------ claims

    @invariant()
    def no_ride_is_lost(self) -> None:
        if not hasattr(self, "campus"):
            return
        known = {plan.vehicle_id: plan for plan in self.campus.read(lambda uow: uow.plans.all())}
        for ride in self.fleet.rides():
            if ride.has_ended:
                assert ride.ended_at is not None, ride
            elif ride.state is RideState.REQUESTED:
                assert ride.vehicle_id is None, ride
            else:
                assert ride.vehicle_id is not None, ride
                assert ride.vehicle_id not in self.retired, ride
                assert ride.ride_id in known[ride.vehicle_id].ride_ids, ride

    def teardown(self) -> None:
        if not hasattr(self, "campus"):
            return
        try:
            self.settle()
        finally:
            self.campus.close()

    def settle(self) -> None:
        """Everything works again: every ride comes to its end."""
        for shuttle in self.fleet.shuttles:
            if shuttle.vehicle_id not in self.retired:
                shuttle.recover()
        for _ in range(SETTLED_WITHIN_STEPS):
            if not self.fleet.waiting():
                return
            before = [(shuttle.place, shuttle.sequence) for shuttle in self.fleet.shuttles]
            self.fleet.step()
            if before == [(shuttle.place, shuttle.sequence) for shuttle in self.fleet.shuttles]:
                self.campus.clock.advance(IDLE_S)
        raise AssertionError(f"{self.fleet.waiting()}\n{self.fleet.stuck()}")

    # ------------------------------------------------------------ helpers of the rules

    def some_ride(self, number: int) -> Ride | None:
        known = sorted(self.fleet.rides(), key=lambda ride: (ride.has_ended, ride.ride_id))
        return known[number % len(known)] if known else None

    def send(self, shuttle: FakeShuttle, boot_id: str, sequence: int, body: VehicleEvent) -> None:
        now_ns = ns_of(self.campus.clock.now())
        event = RecordedEvent(shuttle.vehicle_id, boot_id, sequence, now_ns, now_ns, body)
        self.campus.do(lambda uow: events.apply_event(uow, event))

    def try_(self, work: Any) -> None:
        """A refusal by a rule of the house is an answer; anything else is a defect."""
        before = self.campus.read(lambda uow: uow.views.rides())
        try:
            work()
        except DomainError:
            assert self.campus.read(lambda uow: uow.views.rides()) == before
