"""Which headers carry a token."""

from typing import Any

import pytest
from fastapi import WebSocket

from server.api.security.bearer import bearer_of


async def _unused(*_: Any) -> Any:
    raise AssertionError("a token is in the first headers")


def token_of(*headers: tuple[bytes, bytes]) -> str:
    return bearer_of(WebSocket({"type": "websocket", "headers": headers}, _unused, _unused))


@pytest.mark.parametrize("kind", [b"Bearer", b"bearer", b"BEARER"])
def test_the_word_before_a_token_may_be_written_in_any_case(kind: bytes) -> None:
    assert token_of((b"authorization", kind + b" secret-1")) == "secret-1"


@pytest.mark.parametrize("value", [b"Basic b3BlcmF0b3I6c2VjcmV0", b"secret-1", b"Bearer", b""])
def test_another_kind_of_credentials_is_no_token(value: bytes) -> None:
    assert token_of((b"authorization", value)) == ""


def test_without_the_header_there_is_no_token() -> None:
    assert token_of((b"cookie", b"session=1")) == ""
