"""Enabling by-wire, tick by tick: asked for in two ticks, answered in time, and never taken from a driver."""

import pytest

from vehicle_agent.can.handshake import ANSWER_WITHIN_NS, Handshake, advance

NOW_NS = 1_000_000_000
ASKED = Handshake("enable", NOW_NS, 1)


def after(
    handshake: Handshake, now_ns: int, requested: bool = True, enabled: bool = False, overridden: bool = False
) -> Handshake:
    return advance(handshake, requested, enabled, overridden, now_ns)


def test_a_request_clears_overrides_in_one_tick_and_enables_in_the_next() -> None:
    cleared = after(Handshake(), NOW_NS)
    assert cleared == Handshake("clear", NOW_NS)
    assert (cleared.clears, cleared.enables, cleared.is_on) == (True, False, False)
    asked = after(cleared, NOW_NS + 20)
    assert asked == Handshake("enable", NOW_NS + 20)
    assert (asked.clears, asked.enables, asked.is_on) == (False, True, False)
    on = after(asked, NOW_NS + 40, enabled=True)
    assert on == Handshake("on", NOW_NS + 40)
    assert (on.clears, on.enables, on.is_on) == (False, True, True)


@pytest.mark.parametrize(
    ("late_ns", "overridden", "phase", "refusals"),
    [
        (ANSWER_WITHIN_NS, False, "enable", 1),
        (ANSWER_WITHIN_NS + 1, False, "clear", 2),
        (ANSWER_WITHIN_NS + 1, True, "barred", 2),
    ],
)
def test_without_an_answer_it_is_asked_again_and_a_driver_is_left_alone(
    late_ns: int, overridden: bool, phase: str, refusals: int
) -> None:
    waited = after(ASKED, NOW_NS + late_ns, overridden=overridden)
    assert (waited.phase, waited.refusals) == (phase, refusals)


def test_an_enable_report_beside_an_override_is_no_answer() -> None:
    assert after(ASKED, NOW_NS + 1, enabled=True, overridden=True) is ASKED


def test_an_answer_forgets_earlier_refusals() -> None:
    assert after(ASKED, NOW_NS + 1, enabled=True) == Handshake("on", NOW_NS + 1, 0)


@pytest.mark.parametrize(
    ("enabled", "overridden", "phase"),
    [(True, False, "on"), (True, True, "barred"), (False, True, "barred"), (False, False, "clear")],
)
def test_a_module_that_drops_out_is_asked_again_and_one_that_a_driver_took_is_not(
    enabled: bool, overridden: bool, phase: str
) -> None:
    assert after(Handshake("on", 1), NOW_NS, enabled=enabled, overridden=overridden).phase == phase


@pytest.mark.parametrize("phase", ["clear", "enable", "on", "barred"])
def test_without_a_request_everything_is_off_and_a_driver_may_be_asked_anew(phase: str) -> None:
    off = after(Handshake(phase, 1, 2), NOW_NS, requested=False, enabled=True)  # type: ignore[arg-type]
    assert off == Handshake("off", NOW_NS)
    assert after(off, NOW_NS + 20, requested=False) is off
    assert after(off, NOW_NS + 20).phase == "clear"


def test_barred_stays_barred_however_long_the_request_lasts() -> None:
    barred = Handshake("barred", NOW_NS)
    assert after(barred, NOW_NS + 10**12, enabled=True) is barred
