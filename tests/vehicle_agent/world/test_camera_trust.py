"""When a camera is believed that nobody is in its area."""

import pytest

from vehicle_agent.signals import PedestrianPresence
from vehicle_agent.world.camera_trust import CameraTrust, TrustRules

RULES = TrustRules()
S = 1_000_000_000
NONE: frozenset[str] = frozenset()
HERE = frozenset({"a"})


def after(
    *counts: int, every_s: float = 0.2, by_server: bool = True, tracked_in: frozenset[str] = NONE
) -> tuple[CameraTrust, int]:
    """(trust, stamp) after pictures with these counts."""
    trusts: tuple[CameraTrust, ...] = ()
    stamp_ns = S
    for count in counts:
        stamp_ns += round(every_s * S)
        report = PedestrianPresence(stamp_ns, "a", count, by_server)
        # The same report is there in many ticks.
        for _ in range(3):
            trusts = RULES.update(trusts, (report,), tracked_in)
    (trust,) = trusts
    return trust, stamp_ns


@pytest.mark.parametrize(
    ("counts", "every_s", "is_clear"),
    [
        ((0, 0, 0), 0.2, True),
        ((0, 0, 0), 1.0, True),
        ((0, 0, 0), 1.5, False),
        ((0, 0), 0.2, False),
        ((0, 0, 0, 1), 0.2, False),
        ((0, 0, 0, 1, 0, 0), 0.2, False),
        ((1, 0, 0, 0), 0.2, True),
    ],
)
def test_three_pictures_in_a_row_without_anybody_are_believed(
    counts: tuple[int, ...], every_s: float, is_clear: bool
) -> None:
    trust, stamp_ns = after(*counts, every_s=every_s)
    assert RULES.clear_ns(trust, stamp_ns) == (stamp_ns if is_clear else 0)


def test_a_word_that_did_not_come_by_the_server_is_not_believed_but_slows() -> None:
    trust, stamp_ns = after(0, 0, 0, 0, by_server=False)
    assert RULES.clear_ns(trust, stamp_ns) == 0
    trusts = (after(0, 0, 0)[0],)
    (trust,) = RULES.update(trusts, (PedestrianPresence(stamp_ns + S, "a", 2),), NONE)
    assert RULES.clear_ns(trust, stamp_ns + S) == 0


def test_a_camera_that_misses_somebody_whom_the_vehicle_sees_is_not_believed_for_minutes() -> None:
    trust, stamp_ns = after(0, 0, 0, tracked_in=HERE)
    assert trust.distrusted_ns == stamp_ns
    trusts, report = (trust,), PedestrianPresence(stamp_ns, "a", 0, True)
    for _ in range(10):
        stamp_ns += S // 5
        report = PedestrianPresence(stamp_ns, "a", 0, True)
        trusts = RULES.update(trusts, (report,), NONE)
    assert RULES.clear_ns(trusts[0], stamp_ns) == 0
    assert RULES.clear_ns(trusts[0], stamp_ns + RULES.distrust_ns) > 0


def test_one_picture_that_misses_somebody_only_pauses_the_belief() -> None:
    trusts, stamp_ns = (after(0, 0, 0)[0],), 2 * S
    (trust,) = RULES.update(trusts, (PedestrianPresence(stamp_ns, "a", 0, True),), HERE)
    assert RULES.clear_ns(trust, stamp_ns) == 0
    (trust,) = RULES.update((trust,), (PedestrianPresence(stamp_ns + S // 5, "a", 0, True),), NONE)
    assert RULES.clear_ns(trust, stamp_ns + S // 5) > 0


def test_a_silent_camera_starts_again_and_its_lies_are_remembered() -> None:
    honest, liar = after(0, 0, 0)[0], after(0, 0, 0, tracked_in=HERE)[0]
    assert RULES.update((honest,), (), NONE) == ()
    (kept,) = RULES.update((liar,), (), NONE)
    assert (kept.clear_looks, kept.distrusted_ns) == (0, liar.distrusted_ns)
