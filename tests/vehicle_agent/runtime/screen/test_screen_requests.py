"""What the onboard screen may ask for, and how often."""

import pytest

from vehicle_agent.runtime.screen.screen_requests import (
    CODES_MAX,
    CODES_NS,
    REQUESTS_MAX,
    CodeRequest,
    HelpRequest,
    RequestLimit,
    StopRequest,
    cabin_input,
    decode_request,
)
from vehicle_agent.signals import CodeTyped, DestinationChoice, HelpButton, SeatButton


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ('{"type":"stop","seat":2}', SeatButton(7, 2)),
        ('{"type":"help"}', HelpButton(7)),
        ('{"type":"code","code":"1234"}', CodeTyped(7, "1234")),
        ('{"type":"destination","stop_id":"a"}', DestinationChoice(7, "", "a")),
    ],
)
def test_a_request_becomes_what_a_button_gives(text: str, expected: object) -> None:
    request = decode_request(text)
    assert request is not None
    assert cabin_input(request, 7) == expected


@pytest.mark.parametrize(
    "text",
    [
        "",
        "{}",
        '{"type":"resume"}',
        '{"type":"stop","seat":0}',
        '{"type":"stop","seat":"1"}',
        '{"type":"code","code":"' + "1" * 21 + '"}',
        "[" * 600,
        b"\xff",
    ],
)
def test_what_is_no_request_is_none(text: str) -> None:
    assert decode_request(text) is None


def test_codes_cannot_be_tried_out() -> None:
    limit = RequestLimit()
    taken = [limit.take(CodeRequest("0000"), number) for number in range(CODES_MAX + 1)]
    assert taken == [True] * CODES_MAX + [False]
    assert limit.take(StopRequest(1), 10)
    assert limit.take(CodeRequest("0000"), CODES_NS)


def test_a_flood_of_touches_does_not_keep_a_call_for_help_out() -> None:
    limit = RequestLimit()
    assert [limit.take(StopRequest(1), 0) for _ in range(REQUESTS_MAX + 1)][-1] is False
    assert limit.take(HelpRequest(), 0)
