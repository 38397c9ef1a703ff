"""Over random situations: every text can be read, every sentence is said once for its occasion."""

import itertools
from collections import Counter
from typing import Any

import msgspec
from hypothesis import given, settings
from hypothesis import strategies as st

from contract.runlog.arrays import dec_hook, enc_hook
from tests.vehicle_agent.hmi.streets import TICK_NS, path, task, verdict, world
from vehicle_agent.config import Profile
from vehicle_agent.hmi import texts
from vehicle_agent.hmi.announcer import HmiState
from vehicle_agent.signals import HmiOutput
from vehicle_agent.stacks.rooms import announcer

# What may replace a text before it has been read, by rank.
RANKS = {
    texts.STEP_ASIDE[0]: 1,
    texts.DOORS_OPEN[0]: 2,
    texts.DOORS_CLOSING[0]: 2,
    texts.SAFETY_STOP[0]: 3,
    texts.MANUAL[0]: 4,
}
BACK_TURNED = (18.0, 0.0, 0.0, 0.0, 0.0)

situations = st.fixed_dictionaries(
    {
        "ticks": st.sampled_from((1, 3, 10, 40, 90, 300, 700)),
        "mode": st.sampled_from(("autonomous",) * 6 + ("held", "manual", "minimal_risk")),
        "task_mode": st.sampled_from(("drive",) * 5 + ("dwell", "hold")),
        "limited_by": st.sampled_from(
            ("waypoint_speed", "obstacle", "passing", "yielding", "pedestrian_clearance")
        ),
        "speed_mps": st.sampled_from((0.0, 0.02, 1.5, 3.0)),
        "yields_to": st.sampled_from(((), (), (1,))),
        "doors_open": st.sampled_from((False, False, False, True)),
        "visit_id": st.sampled_from(("v1", "v1", "v2")),
        "stop_m": st.sampled_from((80.0, 10.0)),
        "reason": st.sampled_from((None, None, "requested_stop")),
        "people": st.sampled_from(((), (), (BACK_TURNED,))),
    }
)
Situations = list[dict[str, Any]]


def played(found: Situations, resume_at: int = -1) -> list[HmiOutput]:
    """What was said in each tick; at tick `resume_at` the state goes through bytes and back."""
    room = announcer(Profile())
    state, said, k = room.initial(), [], 0
    for one in found:
        now_task = task(
            mode=one["task_mode"],
            doors_open=one["doors_open"],
            visit_id=one["visit_id"],
            stop_name_en=f"Stop {one['visit_id']}",
            reason=one["reason"],
            aboard=("r1",),
        )
        names = ("limited_by", "speed_mps", "yields_to", "stop_m")
        now_path = path(**{name: one[name] for name in names})
        for _ in range(one["ticks"]):
            k += 1
            if k == resume_at:
                data = msgspec.msgpack.encode(state, enc_hook=enc_hook)
                state = msgspec.msgpack.decode(data, type=HmiState, dec_hook=dec_hook)
            around = world(k // 5 * 5 * TICK_NS, list(one["people"]))
            says, state = room.step(state, now_task, now_path, around, verdict(one["mode"]), k * TICK_NS)
            said.append(says)
    return said


@settings(max_examples=60, deadline=None)
@given(st.lists(situations, min_size=2, max_size=14))
def test_no_text_is_shorter_than_its_minimum_unless_a_warning_replaces_it(found: Situations) -> None:
    said = played(found)
    for side in ("front", "rear"):
        shown = [(s.screen, s.screen) if side == "front" else (s.rear, s.screen) for s in said]
        groups = [list(group) for _, group in itertools.groupby(shown, key=lambda t: t[0])]
        runs, fronts = [len(group) for group in groups], [group[0][1] for group in groups]
        for ticks, front, following in zip(runs, fronts, fronts[1:], strict=False):
            read = ticks * TICK_NS >= announcer(Profile()).show_ns
            assert read or RANKS.get(following, 0) >= 1, (side, front, following, ticks)


@settings(max_examples=60, deadline=None)
@given(st.lists(situations, min_size=2, max_size=14))
def test_no_sentence_is_said_twice_for_one_occasion(found: Situations) -> None:
    said = played(found)
    at = [(k, says.announce) for k, says in enumerate(said) if says.announce]
    count = Counter(text for _, text in at)
    doors = [one["doors_open"] for one in found]
    opened = sum(now and not before for before, now in itertools.pairwise([False, *doors]))
    assert count[texts.SAY_DOORS_OPEN[0]] <= opened
    assert count[texts.SAY_DOORS_CLOSING[0]] <= opened
    assert count[texts.SAY_SAFETY_STOP[0]] <= 1
    assert count[texts.SAY_HELD[0]] <= 1
    visits = [visit for visit, _ in itertools.groupby(one["visit_id"] for one in found)]
    for visit in ("v1", "v2"):
        assert count[texts.say_next_stop("", f"Stop {visit}")[0]] <= visits.count(visit)
        assert count[texts.say_stopping_at("", f"Stop {visit}")[0]] <= visits.count(visit)
    room = announcer(Profile())
    assert count[texts.SAY_STEP_ASIDE[0]] <= 1 + len(said) * TICK_NS // room.aside_again_ns
    outside = count[texts.SAY_AFTER_YOU[0]] + count[texts.SAY_PASSING[0]]
    assert outside <= 1 + len(said) * TICK_NS // room.courtesy_ns
    assert all(b - a >= room.gap_ns // TICK_NS for (a, _), (b, _) in itertools.pairwise(at))


@settings(max_examples=20, deadline=None)
@given(st.lists(situations, min_size=2, max_size=8), st.integers(1, 400))
def test_a_room_restored_from_bytes_goes_on_the_same(found: Situations, tick: int) -> None:
    assert played(found, resume_at=tick) == played(found)
