"""The examples of the JSON-RPC 2.0 specification, and ours, as one table."""

import asyncio
from typing import Annotated, Any

import msgspec
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from server.api.sockets.json_rpc import (
    BATCH_MAX,
    Method,
    answer,
    notification,
)
from server.domain.errors import StopUnknown


class Subtract(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    minuend: int
    subtrahend: Annotated[int, msgspec.Meta(ge=0)] = 1


class Nothing(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    pass


CALLED: list[str] = []


async def subtract(params: Subtract) -> int:
    CALLED.append("subtract")
    return params.minuend - params.subtrahend


async def refuse(_: Nothing) -> None:
    raise StopUnknown("there is no such stop")


METHODS = {
    "subtract": Method(Subtract, "read", int, subtract),
    "refuse": Method(Nothing, "read", None, refuse),
    "drive": Method(Nothing, "drive", None, refuse),
}
SCOPES = frozenset({"read"})


def ask(data: bytes | str) -> Any:
    CALLED.clear()
    response = asyncio.run(answer(data, METHODS, SCOPES))
    return None if response is None else msgspec.json.decode(response)


def a_request(method: str, params: object = None, number: object = 1) -> dict[str, object]:
    request: dict[str, object] = {"jsonrpc": "2.0", "method": method, "id": number}
    return request if params is None else request | {"params": params}


def asked(request: object) -> Any:
    return ask(msgspec.json.encode(request))


@pytest.mark.parametrize(
    ("request_", "result"),
    [
        (a_request("subtract", [42, 23]), 19),
        (a_request("subtract", [23, 42], "text-id"), -19),
        (a_request("subtract", {"subtrahend": 23, "minuend": 42}, None), 19),
        (a_request("subtract", [42]), 41),
    ],
)
def test_params_go_by_position_or_by_name(request_: dict[str, object], result: int) -> None:
    assert asked(request_) == {"jsonrpc": "2.0", "id": request_["id"], "result": result}


@pytest.mark.parametrize(
    ("data", "code", "number"),
    [
        (b'{"jsonrpc": "2.0", "method": "foobar, "params": "bar", "baz]', -32700, None),
        (b"\xff", -32700, None),
        (b"[" * 100_000, -32700, None),
        (b'[{"jsonrpc": "2.0", "method": "sum", "id": "1"},{"jsonrpc": "2.0", "method"', -32700, None),
        (b'{"jsonrpc": "2.0", "method": 1, "params": "bar"}', -32600, None),
        (b'{"jsonrpc": "1.0", "method": "subtract", "id": 7}', -32600, 7),
        (b'{"method": "subtract", "id": 7}', -32600, 7),
        (b'{"jsonrpc": "2.0", "method": "subtract", "params": 5, "id": 7}', -32600, 7),
        (b'{"jsonrpc": "2.0", "method": "subtract", "id": {"a": 1}}', -32600, None),
        (b'{"jsonrpc": "2.0", "method": "subtract", "id": true}', -32600, None),
        (b"1", -32600, None),
        (b"[]", -32600, None),
        (b'{"jsonrpc": "2.0", "method": "foobar", "id": "1"}', -32601, "1"),
        (b'{"jsonrpc": "2.0", "method": "subtract", "params": [1, 2, 3], "id": 1}', -32602, 1),
        (b'{"jsonrpc": "2.0", "method": "subtract", "params": ["a"], "id": 1}', -32602, 1),
        (b'{"jsonrpc": "2.0", "method": "subtract", "params": {"minuend": 1, "x": 2}, "id": 1}', -32602, 1),
        (b'{"jsonrpc": "2.0", "method": "subtract", "params": [1, -1], "id": 1}', -32602, 1),
        (b'{"jsonrpc": "2.0", "method": "subtract", "id": 1}', -32602, 1),
        (b'{"jsonrpc": "2.0", "method": "refuse", "id": 1}', -32000, 1),
        (b'{"jsonrpc": "2.0", "method": "drive", "id": 1}', -32001, 1),
    ],
)
def test_what_is_wrong_gets_its_number(data: bytes, code: int, number: object) -> None:
    response = ask(data)
    assert response["error"]["code"] == code
    assert response["id"] == number
    assert "result" not in response


def test_a_domain_refusal_carries_its_code_and_what_to_do() -> None:
    error = asked(a_request("refuse"))["error"]
    assert error["data"] == {"code": "stop_unknown", "detail": "there is no such stop"}


@pytest.mark.parametrize(
    "request_",
    [
        {"jsonrpc": "2.0", "method": "subtract", "params": [3, 2]},
        {"jsonrpc": "2.0", "method": "refuse"},
        {"jsonrpc": "2.0", "method": "foobar"},
    ],
)
def test_a_notification_is_never_answered(request_: dict[str, object]) -> None:
    assert asked(request_) is None


def test_a_notification_is_carried_out() -> None:
    asked({"jsonrpc": "2.0", "method": "subtract", "params": [3, 2]})
    assert CALLED == ["subtract"]


def test_a_batch_answers_each_request_and_no_notification() -> None:
    batch = [
        a_request("subtract", [42, 23], "1"),
        {"jsonrpc": "2.0", "method": "subtract", "params": [1]},
        {"foo": "boo"},
        a_request("foobar", number="5"),
        1,
    ]
    answers = asked(batch)
    assert [item.get("result", item.get("error", {}).get("code")) for item in answers] == [
        19,
        -32600,
        -32601,
        -32600,
    ]
    assert [item["id"] for item in answers] == ["1", None, "5", None]


def test_a_batch_of_notifications_is_answered_by_nothing() -> None:
    assert asked([{"jsonrpc": "2.0", "method": "subtract", "params": [1]}] * 2) is None


def test_a_batch_longer_than_allowed_is_refused_whole() -> None:
    response = asked([a_request("subtract", [1])] * (BATCH_MAX + 1))
    assert response["error"]["code"] == -32600
    assert CALLED == []


def test_a_notification_of_ours_has_no_id() -> None:
    assert msgspec.json.decode(notification("rides", {"a": 1})) == {
        "jsonrpc": "2.0",
        "method": "rides",
        "params": {"a": 1},
    }


@settings(max_examples=150, deadline=None)
@given(
    st.recursive(
        st.none() | st.booleans() | st.integers(-5, 5) | st.sampled_from(["2.0", "subtract", "refuse", "x"]),
        lambda inner: (
            st.lists(inner, max_size=4)
            | st.dictionaries(st.sampled_from(["jsonrpc", "method", "params", "id", "minuend"]), inner)
        ),
        max_leaves=10,
    )
)
def test_no_json_breaks_the_answer(value: object) -> None:
    response = asked(value)
    for item in response if isinstance(response, list) else [response]:
        if item is not None:
            assert item["jsonrpc"] == "2.0"
            assert ("result" in item) != ("error" in item)
