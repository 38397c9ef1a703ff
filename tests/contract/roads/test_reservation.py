"""The section controller: never two in one place, never stuck."""

import random
from itertools import pairwise

import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, precondition, rule

from contract.roads.load import MapError
from contract.roads.model import Section
from contract.roads.reservation import ReservationError, Reservations
from contract.roads.safety import FreeWay, Ground
from tests.contract.roads.driven_fleet import DrivenFleet
from tests.contract.roads.generated_maps import generated_map


def single_track(length: int) -> list[Section]:
    """One track of `length` pieces, driven both ways: e0, e1, ... eastwards; w0 lies on e0.

    The bays lie beside its two ends.
    """
    east = [Section(f"e{k}", "east", k, k + 1, (f"w{k}",)) for k in range(length)]
    west = [Section(f"w{k}", "west", k, k + 1, (f"e{k}",)) for k in range(length)]
    bays = [Section("west-bay", "bays", 0, 1), Section("west-bay-2", "bays", 1, 2)]
    return [*east, *west, *bays, Section("east-bay", "bays", 2, 3), Section("east-bay-2", "bays", 3, 4)]


def eastwards(length: int) -> tuple[str, ...]:
    return ("west-bay", *(f"e{k}" for k in range(length)), "east-bay")


def westwards(length: int) -> tuple[str, ...]:
    return ("east-bay-2", *(f"w{k}" for k in reversed(range(length))), "west-bay-2")


@pytest.fixture
def meeting() -> Reservations:
    """Two vehicles at the two ends of a single track, each on its way to the other end."""
    control = Reservations(single_track(3))
    control.place("a", ("west-bay",))
    control.place("b", ("east-bay-2",))
    assert control.adopt("a", eastwards(3))
    assert control.adopt("b", westwards(3))
    return control


def test_two_vehicles_never_enter_a_single_track_from_both_ends(meeting: Reservations) -> None:
    assert [grant.section_id for grant in meeting.grant("a", 1)] == ["e0"]
    assert meeting.grant("b", 1) == ()
    assert meeting.blocked_by("b") == ("a",)
    assert meeting.blocked_by("a") == ()


def test_a_route_may_end_on_a_section_that_is_held_with_more_ahead_of_it() -> None:
    """The shuttle was given more road than its new route needs; the rest stays held until it is released."""
    control = Reservations(single_track(3))
    control.place("a", ("west-bay",))
    assert control.adopt("a", eastwards(3))
    assert len(control.grant("a", 10)) == 4
    assert control.adopt("a", ("west-bay", "e0", "e1"))
    assert control.ahead("a") == ()
    assert control.held("a") == eastwards(3)


def test_the_second_vehicle_goes_once_the_first_is_through(meeting: Reservations) -> None:
    assert len(meeting.grant("a", 10)) == 4
    assert meeting.blocked_by("b") == ("a",)
    for section_id in ("west-bay", "e0", "e1", "e2"):
        assert meeting.release("a", section_id)
    assert len(meeting.grant("b", 10)) == 4


def test_vehicles_may_follow_each_other_along_a_single_track() -> None:
    control = Reservations(single_track(3))
    control.place("a", ("e1",))
    control.place("b", ("west-bay",))
    assert control.adopt("a", ("e1", "e2", "east-bay"))
    assert control.adopt("b", ("west-bay", "e0", "e1", "e2", "east-bay-2"))
    assert [grant.section_id for grant in control.grant("b", 5)] == ["e0"]


def test_a_vehicle_does_not_follow_one_that_would_have_to_come_back() -> None:
    sections = [*single_track(3), Section("stub", "stub", 0, 1)]
    control = Reservations(sections)
    control.place("a", ("e1",))
    control.place("b", ("west-bay",))
    assert control.adopt("a", ("e1", "e2", "stub", "w2", "w1", "w0", "west-bay-2"))
    assert control.adopt("b", eastwards(3))
    assert control.grant("b", 5) == ()
    assert control.blocked_by("b") == ("a",)


def test_fences_grow_with_every_grant(meeting: Reservations) -> None:
    fences = [grant.fence for grant in (*meeting.grant("a", 2), *meeting.grant("a", 2))]
    assert fences == sorted(set(fences))
    assert len(fences) == 4


def test_fences_go_on_after_a_restart() -> None:
    control = Reservations(single_track(3), last_fence=41)
    control.place("a", ("west-bay",))
    control.adopt("a", eastwards(3))
    assert control.grant("a", 1)[0].fence == 42
    assert control.last_fence == 42


def test_a_route_that_cannot_be_finished_is_refused_and_changes_nothing(meeting: Reservations) -> None:
    meeting.grant("a", 1)
    before = meeting.ahead("b")
    assert not meeting.adopt("b", ("east-bay-2", "east-bay"))
    assert meeting.ahead("b") == before
    assert meeting.is_safe()


def test_a_route_may_leave_a_held_section_which_then_stays_held_until_released() -> None:
    control = Reservations(single_track(3))
    control.place("a", ("e0", "e1"))
    assert control.adopt("a", ("e0", "west-bay"))
    assert control.held("a") == ("e0", "e1")
    assert control.ahead("a") == ("west-bay",)
    assert control.release("a", "e1")
    assert control.held("a") == ("e0",)


def test_what_lies_behind_on_an_adopted_route_is_not_driven_again() -> None:
    control = Reservations(single_track(3))
    control.place("a", ("e1",))
    assert control.adopt("a", eastwards(3))
    assert control.ahead("a") == ("e2", "east-bay")


def test_releasing_twice_is_harmless_and_the_last_section_is_kept(meeting: Reservations) -> None:
    meeting.grant("a", 1)
    assert meeting.release("a", "west-bay")
    assert not meeting.release("a", "west-bay")
    with pytest.raises(ReservationError, match="holds_nothing"):
        meeting.release("a", "e0")


@pytest.mark.parametrize(
    ("code", "act"),
    [
        ("unknown_vehicle", lambda control: control.grant("ghost", 1)),
        ("unknown_section", lambda control: control.place("c", ("nowhere",))),
        ("unknown_section", lambda control: control.adopt("a", ("west-bay", "nowhere"))),
        ("holds_nothing", lambda control: control.place("c", ())),
        ("off_route", lambda control: control.adopt("a", ("e1", "e2"))),
        ("conflict", lambda control: control.place("c", ("west-bay",))),
    ],
)
def test_contradictory_requests_are_refused_by_name(meeting: Reservations, code: str, act: object) -> None:
    with pytest.raises(ReservationError) as caught:
        act(meeting)  # type: ignore[operator]
    assert caught.value.code == code


def test_a_conflict_with_an_unknown_section_is_a_map_error() -> None:
    with pytest.raises(MapError, match="dangling_id"):
        Reservations([Section("a", "lane", 0, 1, ("b",))])


def test_after_a_restart_routes_are_adopted_again_in_any_order_that_works(meeting: Reservations) -> None:
    meeting.grant("a", 2)
    held = {vehicle_id: meeting.held(vehicle_id) for vehicle_id in meeting.vehicle_ids}
    routes = {v: (*held[v], *meeting.ahead(v)) for v in held}
    fresh = Reservations(single_track(3))
    for vehicle_id, sections in held.items():
        fresh.place(vehicle_id, sections)
    waiting = sorted(routes, reverse=True)
    while waiting:
        adopted = [v for v in waiting if fresh.adopt(v, routes[v])]
        assert adopted
        waiting = [v for v in waiting if v not in adopted]
    assert fresh.is_safe()


def test_a_stranded_vehicle_holds_up_only_those_who_need_its_place() -> None:
    control = Reservations(single_track(4))
    control.place("a", ("west-bay",))
    control.place("b", ("east-bay-2",))
    assert control.adopt("a", ("west-bay", "e0", "e1", "west-bay-2"))
    control.place("stranded", ("e3",))
    assert not control.adopt("b", westwards(4))
    assert len(control.grant("a", 5)) == 3


def ring(length: int, piece_m: float = 24.0) -> Reservations:
    """A one-way ring r0, r1, ..., with a bay beside r0 and one beside the middle."""
    sections = [Section(f"r{k}", "ring", piece_m * k, piece_m * (k + 1)) for k in range(length)]
    return Reservations([*sections, Section("bay", "bay", 0, 24), Section("far-bay", "far-bay", 0, 24)])


def test_a_shuttle_sets_out_round_a_ring_ahead_of_one_that_stands_at_a_stop() -> None:
    """Its round leads back to where the other stands, which goes on long before."""
    control = ring(8)
    control.place("standing", ("r7",))
    control.place("leaving", ("bay",))
    assert control.adopt("standing", ("r7", "r0", "r1", "r2", "far-bay"))
    assert control.adopt("leaving", ("bay", *(f"r{k}" for k in range(1, 8)), "r0", "bay"))
    # It goes no farther than round to the one that stands, and there is nobody's way to wait in.
    assert len(control.grant("leaving", 20)) == 6
    assert control.is_safe()


@pytest.mark.parametrize(("piece_m", "safe"), [(5.05, False), (5.15, True)])
def test_a_place_to_wait_holds_a_body_and_what_it_keeps_before_and_behind_it(
    piece_m: float, safe: bool
) -> None:
    """4.35 m of body, 0.5 m before the next section, and 0.25 m until the last one is released."""
    control = ring(8, piece_m)
    control.place("a", ("r1",))
    control.place("b", ("r5",))
    assert control.adopt("a", ("r1", "r2", "r3", "r4", "r5", "r6", "bay"))
    assert control.adopt("b", ("r5", "r6", "r7", "r0", "r1", "r2", "far-bay"))
    assert control.is_safe() is safe


def test_two_that_were_put_in_each_others_way_get_free_by_both_routes() -> None:
    control = ring(8)
    control.place("a", ("r1",))
    control.place("b", ("r5",))
    assert control.adopt("a", ("r1", "r2", "r3", "r4", "r5", "r6", "bay"))
    assert control.grant("a", 1) == ()
    assert control.adopt("b", ("r5", "r6", "r7", "r0", "r1", "r2", "far-bay"))
    assert control.is_safe()
    assert control.grant("a", 1)


@st.composite
def _claims(draw: st.DrawFn) -> tuple[list[Section], dict[str, list[str]]]:
    """Lanes whose sections exclude each other at random; a route over some of them for each vehicle."""
    lanes = [[f"{lane}{k}" for k in range(draw(st.integers(1, 4)))] for lane in "pqr"]
    names = [name for lane in lanes for name in lane]
    pairs = draw(st.lists(st.tuples(st.sampled_from(names), st.sampled_from(names)), max_size=6))
    conflicts: dict[str, set[str]] = {name: set() for name in names}
    for one, other in pairs:
        if one != other:
            conflicts[one].add(other)
            conflicts[other].add(one)
    length_m = draw(st.sampled_from((24.0, 3.0)))
    sections = [
        Section(name, name[0], k * length_m, (k + 1) * length_m, tuple(sorted(conflicts[name])))
        for lane in lanes
        for k, name in enumerate(lane)
    ]
    taken: set[str] = set()
    routes = {}
    for vehicle_id in ("a", "b", "c")[: draw(st.integers(2, 3))]:
        order = draw(st.permutations(lanes))
        way = [name for lane in order[: draw(st.integers(1, 3))] for name in lane]
        way = way[draw(st.integers(0, len(order[0]) - 1)) :]
        if way[0] not in taken:
            taken |= {way[0]} | conflicts[way[0]]
            routes[vehicle_id] = way
    return sections, routes


@given(_claims())
@settings(max_examples=400, deadline=None)
def test_what_is_called_safe_can_be_driven_to_the_end(
    drawn: tuple[list[Section], dict[str, list[str]]],
) -> None:
    sections, routes = drawn
    control = Reservations(sections)
    for vehicle_id, way in routes.items():
        control.restore(vehicle_id, way[:1], way[1:], way[-1])
    assume(control.is_safe())
    while left := sum(len(control.ahead(v)) for v in routes):
        for vehicle_id in routes:
            control.grant(vehicle_id, 1)
            while len(control.held(vehicle_id)) > 1:
                control.release(vehicle_id, control.held(vehicle_id)[0])
            assert control.is_safe()
        assert sum(len(control.ahead(v)) for v in routes) < left, "nobody may go on"


@given(_claims(), st.integers(1, 4))
@settings(max_examples=400, deadline=None)
def test_a_vehicle_with_a_free_way_gets_what_the_whole_test_would_give(
    drawn: tuple[list[Section], dict[str, list[str]]], limit: int
) -> None:
    sections, routes = drawn
    quick, whole = Reservations(sections), Reservations(sections)
    for control in (quick, whole):
        for vehicle_id, way in routes.items():
            control.restore(vehicle_id, way[:1], way[1:], way[-1])
    for vehicle_id in (*routes, *routes):
        granted = quick.grant(vehicle_id, limit)
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(Ground, "free_way", lambda *_: FreeWay.NONE)
            assert whole.grant(vehicle_id, limit) == granted
        for control in (quick, whole):
            control.keep(vehicle_id, control.held(vehicle_id)[-1:])
        assert quick.is_safe() == whole.is_safe()


@pytest.mark.parametrize("seed", range(6))
def test_random_missions_on_made_up_campuses_all_complete(seed: int) -> None:
    rng = random.Random(seed)
    road_map = generated_map(seed)
    fleet = DrivenFleet(road_map, min(3 + seed % 3, len(road_map.resting_places) - 1))
    for _ in range(10_000):
        if sum(fleet.missions.values()) >= 60:
            break
        for vehicle_id in fleet.control.vehicle_ids:
            if fleet.is_idle(vehicle_id):
                assert fleet.send(vehicle_id, rng.randrange(99), rng.randrange(99))
        for vehicle_id in fleet.control.vehicle_ids:
            fleet.step(vehicle_id, rng.randint(1, 4))
    fleet.finish(rng)
    assert sum(fleet.missions.values()) >= 60
    assert all(a < b for a, b in pairwise(fleet.fences))


class SharedRoads(RuleBasedStateMachine):
    """Any order of sending, asking, moving and restarting keeps the state safe; all missions then end."""

    @initialize(seed=st.integers(0, 5), count=st.integers(3, 5))
    def start(self, seed: int, count: int) -> None:
        self.seed = seed
        self.fleet = DrivenFleet(generated_map(seed), min(count, len(generated_map(seed).resting_places) - 1))

    @rule(vehicle=st.integers(0, 4), stop=st.integers(0, 20), place=st.integers(0, 20))
    def send(self, vehicle: int, stop: int, place: int) -> None:
        vehicle_id = f"v{vehicle % self.fleet.count}"
        if self.fleet.is_idle(vehicle_id):
            assert self.fleet.send(vehicle_id, stop, place)

    @rule(vehicle=st.integers(0, 4), limit=st.integers(1, 6), turns=st.integers(1, 8))
    def drive(self, vehicle: int, limit: int, turns: int) -> None:
        for _ in range(turns):
            self.fleet.step(f"v{vehicle % self.fleet.count}", limit)

    @rule()
    def restart(self) -> None:
        """The server forgets everything but what each vehicle says it holds and where it was going."""
        old = self.fleet.control
        self.fleet.control = Reservations(self.fleet.road_map.sections, last_fence=old.last_fence)
        for vehicle_id in old.vehicle_ids:
            self.fleet.control.place(vehicle_id, old.held(vehicle_id))
        waiting = [v for v in old.vehicle_ids if old.ahead(v)]
        while waiting:
            refused = [v for v in waiting if not self.fleet.control.adopt(v, (*old.held(v), *old.ahead(v)))]
            assert len(refused) < len(waiting)
            waiting = refused

    @precondition(lambda self: hasattr(self, "fleet"))
    @invariant()
    def nobody_is_locked_in(self) -> None:
        self.fleet.assert_apart()
        assert self.fleet.control.is_safe()

    def teardown(self) -> None:
        if hasattr(self, "fleet"):
            sections_ahead = sum(len(self.fleet.control.ahead(v)) for v in self.fleet.control.vehicle_ids)
            assert self.fleet.finish(random.Random(self.seed)) <= sections_ahead + self.fleet.count


TestSharedRoads = SharedRoads.TestCase
TestSharedRoads.settings = settings(
    max_examples=25, stateful_step_count=25, deadline=None, suppress_health_check=[HealthCheck.too_slow]
)
