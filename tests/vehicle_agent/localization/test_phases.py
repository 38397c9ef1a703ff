"""The phases of localization: which follows which, whatever the scans say, and that each of them ends."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from vehicle_agent.localization.phases import PhaseRules, PhaseState, Seen, next_phase
from vehicle_agent.localization.worker_watch import SILENT_NS, WorkerWatch

TICK_NS = 20_000_000
RULES = PhaseRules(creep_m=5.0, creep_ns=100 * TICK_NS, settled=3)
FINE = Seen(has_pose=True, in_doubt=False, placed_anew=False, agrees=True, has_map=True, way_m=0.0)
PHASES = ("waiting", "tracking", "doubtful", "lost", "recovered", "gnss_only")
# What may follow what, besides itself.
MAY_FOLLOW = {
    "waiting": {"tracking", "gnss_only", "doubtful", "recovered"},
    "tracking": {"waiting", "doubtful", "gnss_only", "recovered"},
    "doubtful": {"waiting", "tracking", "lost", "recovered", "gnss_only"},
    "lost": {"waiting", "recovered", "gnss_only"},
    "recovered": {"waiting", "tracking", "doubtful", "gnss_only"},
    "gnss_only": {"waiting", "tracking", "doubtful", "recovered"},
}
sights = st.builds(
    Seen,
    has_pose=st.booleans(),
    in_doubt=st.booleans(),
    placed_anew=st.booleans(),
    agrees=st.booleans(),
    has_map=st.booleans(),
    way_m=st.floats(0.0, 20.0),
)


def run(state: PhaseState, seen: list[Seen], from_ns: int = TICK_NS) -> PhaseState:
    for number, one in enumerate(seen):
        state = next_phase(state, one, RULES, from_ns + number * TICK_NS)
    return state


def seen(**changes: object) -> Seen:
    return Seen(**{**{name: getattr(FINE, name) for name in FINE.__struct_fields__}, **changes})


@given(st.lists(sights, min_size=1, max_size=300))
def test_phases_follow_each_other_as_drawn(many: list[Seen]) -> None:
    state = PhaseState()
    for number, one in enumerate(many):
        after = next_phase(state, one, RULES, (number + 1) * TICK_NS)
        assert after.phase == state.phase or after.phase in MAY_FOLLOW[state.phase]
        # What is named is never better than what is seen.
        assert one.has_pose or after.phase == "waiting"
        assert not (one.has_pose and one.in_doubt) or after.phase in ("doubtful", "lost")
        assert not (one.has_pose and not one.in_doubt and not one.has_map) or after.phase == "gnss_only"
        state = after


@given(st.lists(sights, max_size=100))
def test_every_phase_ends_by_itself_once_scans_agree(many: list[Seen]) -> None:
    state = run(PhaseState(), many)
    calm = seen(way_m=20.0)
    assert run(state, [calm] * (RULES.settled + 2), TICK_NS * 1000).phase == "tracking"


@given(st.lists(sights, max_size=100), st.floats(0.0, 4.9))
def test_a_vehicle_in_doubt_creeps_only_so_far_and_so_long(many: list[Seen], way_m: float) -> None:
    start = run(PhaseState(), [*many, seen(way_m=0.0)], TICK_NS)
    ticks = len(many) + 2
    doubt = run(start, [seen(in_doubt=True, way_m=0.0)], ticks * TICK_NS)
    assert doubt.phase in ("doubtful", "lost")
    near = run(doubt, [seen(in_doubt=True, way_m=way_m)], (ticks + 1) * TICK_NS)
    assert near.phase == doubt.phase
    assert run(near, [seen(in_doubt=True, way_m=5.0)], (ticks + 2) * TICK_NS).phase == "lost"
    late = run(near, [seen(in_doubt=True, way_m=way_m)], (ticks + 1) * TICK_NS + RULES.creep_ns)
    assert late.phase == "lost"


def test_a_start_waits_for_gnss_or_a_hint() -> None:
    waiting = run(PhaseState(), [seen(has_pose=False)] * 10)
    assert waiting.phase == "waiting"
    assert run(waiting, [FINE]).phase == "tracking"
    assert run(waiting, [seen(in_doubt=True)]).phase == "doubtful"


def test_a_place_found_again_settles_before_it_is_called_tracking() -> None:
    lost = run(PhaseState(), [FINE, seen(in_doubt=True), seen(in_doubt=True, way_m=9.0)])
    assert lost.phase == "lost"
    found = run(lost, [seen(placed_anew=True)])
    assert found.phase == "recovered"
    assert run(found, [FINE] * 2).phase == "recovered"
    assert run(found, [FINE] * 4).phase == "tracking"


@pytest.mark.parametrize("has_map", [True, False])
def test_where_the_map_ends_gnss_is_named(has_map: bool) -> None:
    expected = "tracking" if has_map else "gnss_only"
    assert run(PhaseState(), [FINE, seen(has_map=has_map)]).phase == expected


def test_a_worker_that_answers_is_not_called_silent_and_one_that_does_not_is() -> None:
    watch = WorkerWatch()
    for tick in range(1, 1000):
        watch = watch.after(tick * TICK_NS, asks=True, answered=tick % 50 == 0)
        assert not watch.is_silent(tick * TICK_NS)
    now_ns = 1000 * TICK_NS
    watch = watch.after(now_ns, asks=True, answered=False)
    assert watch.is_silent(now_ns + SILENT_NS)
    assert not watch.after(now_ns, asks=False, answered=False).is_silent(now_ns + SILENT_NS)
