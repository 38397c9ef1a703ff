"""A schedule over time: no accepted request is ever picked up late or rides too long."""

import numpy as np
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from server.dispatch.decide import offers_for, take
from server.dispatch.problem import Plane, Problem, Request, VehicleState
from server.dispatch.schedule.schedule import CompletedCall, Schedule

BOUNDED = settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.too_slow])
PLACES = 24
RIDE_S_MAX = 400.0
DUTY_S_MAX = 3000.0


def drive(seed: int, steps: int, on_plane: bool) -> tuple[dict[str, Request], list[CompletedCall], Schedule]:
    """Requests come in one after the other while two vehicles drive; then everything is driven to its end."""
    rng = np.random.default_rng(seed)
    xy = rng.uniform(0.0, 100.0, (PLACES, 2))
    times = 3.0 * np.linalg.norm(xy[:, None] - xy[None, :], axis=2)
    fleet = tuple(
        VehicleState(
            f"v{k}", times[k], 0.0, 3, 0, at_xy=(xy[k, 0], xy[k, 1]), ends_at=k, duty_s_max=DUTY_S_MAX
        )
        for k in range(2)
    )
    if on_plane:
        problem = Problem(fleet, {}, np.zeros((0, 0)), plane=Plane(xy, 3.0), dwell_s=10.0)
    else:
        problem = Problem(fleet, {}, times, dwell_s=10.0)
    schedule = Schedule(problem, spare=steps)
    taken: dict[str, Request] = {}
    made: list[CompletedCall] = []
    now_s = 0.0
    for k in range(steps):
        now_s += float(rng.exponential(120.0))
        made += schedule.advance(now_s)
        pickup, dropoff = (int(place) for place in rng.choice(PLACES, 2, replace=False))
        from_s = now_s + float(rng.uniform(0.0, 600.0))
        request = Request(
            f"r{k}", pickup, dropoff, int(rng.integers(1, 3)), 0, from_s, from_s + 300.0, np.inf, RIDE_S_MAX
        )
        schedule.add(request)
        best = offers_for(schedule, request.request_id).best
        if best is None:
            schedule.remove(request.request_id)
        else:
            take(schedule, best)
            taken[request.request_id] = request
    made += schedule.advance(now_s + 1e5)
    return taken, made, schedule


@BOUNDED
@given(st.integers(0, 10_000), st.integers(1, 25), st.booleans())
def test_whoever_was_taken_is_driven_within_every_window(seed: int, steps: int, on_plane: bool) -> None:
    taken, made, schedule = drive(seed, steps, on_plane)
    assert not schedule.rows
    assert not schedule.overdue
    picked = {one.request_id: one for one in made if not one.alights}
    let_out = {one.request_id: one for one in made if one.alights}
    assert picked.keys() == let_out.keys() == taken.keys()
    for name, request in taken.items():
        begins_s, ends_s = picked[name].at_s, let_out[name].at_s
        assert picked[name].vehicle_id == let_out[name].vehicle_id
        assert request.pickup_from_s - 1e-6 <= begins_s <= request.pickup_to_s + 1e-5
        assert ends_s - begins_s - 10.0 <= RIDE_S_MAX + 1e-5


@BOUNDED
@given(st.integers(0, 10_000), st.integers(1, 25))
def test_places_on_a_plane_and_their_table_give_the_same_rides(seed: int, steps: int) -> None:
    on_plane, by_table = drive(seed, steps, True), drive(seed, steps, False)
    assert on_plane[0] == by_table[0]
    assert [m.request_id for m in on_plane[1]] == [m.request_id for m in by_table[1]]
    assert abs(on_plane[2].driven_s - by_table[2].driven_s) < 1e-3


@BOUNDED
@given(st.integers(0, 10_000), st.integers(1, 25))
def test_seats_are_never_overbooked_on_the_way(seed: int, steps: int) -> None:
    taken, made, _ = drive(seed, steps, True)
    inside = {"v0": 0, "v1": 0}
    for one in made:
        inside[one.vehicle_id] += (-1 if one.alights else 1) * taken[one.request_id].party
        assert 0 <= inside[one.vehicle_id] <= 3
    assert set(inside.values()) == {0}


@BOUNDED
@given(st.integers(0, 10_000), st.integers(1, 25))
def test_who_changes_their_mind_makes_nobody_else_late(seed: int, steps: int) -> None:
    rng = np.random.default_rng(seed)
    xy = rng.uniform(0.0, 100.0, (PLACES, 2))
    times = 3.0 * np.linalg.norm(xy[:, None] - xy[None, :], axis=2)
    fleet = tuple(VehicleState(f"v{k}", times[k], 0.0, 3, 0) for k in range(2))
    schedule = Schedule(Problem(fleet, {}, times, dwell_s=10.0), spare=steps, departure_slack=0.5)
    wanted: dict[str, Request] = {}
    gone: set[str] = set()
    made: list[CompletedCall] = []
    now_s = 0.0
    for k in range(steps):
        now_s += float(rng.exponential(60.0))
        made += schedule.advance(now_s)
        waiting = sorted(wanted.keys() - gone - {one.request_id for one in made})
        if waiting and rng.random() < 0.4:
            name = waiting[int(rng.integers(len(waiting)))]
            schedule.withdraw(name)
            gone.add(name)
        pickup, dropoff = (int(place) for place in rng.choice(PLACES, 2, replace=False))
        request = Request(f"r{k}", pickup, dropoff, 1, 0, now_s, now_s + 300.0, np.inf, RIDE_S_MAX)
        schedule.add(request)
        best = offers_for(schedule, request.request_id).best
        if best is None:
            schedule.remove(request.request_id)
        else:
            take(schedule, best)
            wanted[request.request_id] = request
    made += schedule.advance(now_s + 1e5)
    picked = {one.request_id: one.at_s for one in made if not one.alights}
    assert picked.keys() == wanted.keys() - gone
    assert all(picked[name] <= wanted[name].pickup_to_s + 1e-5 for name in picked)
    assert not schedule.rows
    assert not schedule.overdue
