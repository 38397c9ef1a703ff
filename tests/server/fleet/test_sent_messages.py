"""What goes to a vehicle now, what again, and what not."""

from contract.wire.messages import Command, Grants, Order, PassengerTap, SectionGrant
from server.fleet.sent_messages import REPEAT_AFTER_NS, SentMessages
from server.usecases.orders.outbox import Outbox

FIRST, SECOND = SectionGrant("a", 1), SectionGrant("b", 2)
ORDER = Order(1, "o", 1, "m", (), (FIRST,), 99)
HOLD = Command(1, "c", "hold")
TAP = PassengerTap(1, "t", "ride", "board")


def an_outbox(*, order: Order | None = None, grants: Grants | None = None, **more: object) -> Outbox:
    fields: dict[str, object] = {"order": order, "grants": grants, "commands": (), "taps": ()}
    return Outbox(**(fields | more))  # type: ignore[arg-type]


def test_what_is_unanswered_is_sent_once_and_again_after_three_seconds() -> None:
    sent, outbox = SentMessages(), an_outbox(order=ORDER, commands=(HOLD,), taps=(TAP,))
    assert not sent.unanswered
    assert sent.choose(outbox, 0) == [ORDER, HOLD, TAP]
    assert sent.unanswered
    assert sent.choose(outbox, REPEAT_AFTER_NS - 1) == []
    assert sent.choose(outbox, REPEAT_AFTER_NS) == [ORDER, HOLD, TAP]
    assert sent.choose(outbox, REPEAT_AFTER_NS + 1) == []
    assert REPEAT_AFTER_NS == 3_000_000_000


def test_what_was_answered_is_not_asked_for_again() -> None:
    sent = SentMessages()
    sent.choose(an_outbox(commands=(HOLD,)), 0)
    assert sent.choose(an_outbox(), REPEAT_AFTER_NS) == []
    assert not sent.unanswered


def test_a_new_revision_goes_out_at_once() -> None:
    sent = SentMessages()
    sent.choose(an_outbox(order=ORDER), 0)
    revised = Order(1, "o", 2, "m", (), (FIRST,), 99)
    assert sent.choose(an_outbox(order=revised), 1) == [revised]


def test_grants_go_out_when_they_change_and_are_no_question() -> None:
    sent = SentMessages()
    grants = Grants(1, "o", (FIRST,))
    assert sent.choose(an_outbox(grants=grants), 0) == [grants]
    assert not sent.unanswered
    assert sent.choose(an_outbox(grants=grants), 10 * REPEAT_AFTER_NS) == []
    more = Grants(1, "o", (FIRST, SECOND))
    assert sent.choose(an_outbox(grants=more), 1) == [more]
    others = Grants(1, "p", (FIRST, SECOND))
    assert sent.choose(an_outbox(grants=others), 2) == [others]


def test_grants_that_came_with_the_order_are_not_sent_a_second_time() -> None:
    sent = SentMessages()
    sent.choose(an_outbox(order=ORDER), 0)
    assert sent.choose(an_outbox(grants=Grants(1, "o", (FIRST,))), 1) == []
