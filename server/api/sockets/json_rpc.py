"""JSON-RPC 2.0 without I/O: the bytes of a request in, the bytes of its answer out (or nothing).

Source: the JSON-RPC 2.0 specification (jsonrpc.org). Domain refusals travel as error -32000 with the
problem's code in `data`; a token without the scope gets -32001.
"""

from collections.abc import Awaitable, Callable, Mapping
from dataclasses import dataclass
from typing import Any

import msgspec

from server.domain.errors import DomainError

PARSE_ERROR = -32700
INVALID_REQUEST = -32600
METHOD_NOT_FOUND = -32601
INVALID_PARAMS = -32602
REFUSED = -32000
SCOPE_MISSING = -32001
BATCH_MAX = 50


class RpcError(Exception):
    """An answer with `error`: number, message and optional data."""

    def __init__(self, number: int, message: str, data: object = None) -> None:
        super().__init__(message)
        self.number, self.message, self.data = number, message, data


@dataclass(frozen=True, slots=True)
class Method:
    """params  a msgspec struct; positional params fill its fields in order
    scope   what the caller's token must allow
    result  the type of what `call` returns
    call    may raise DomainError or RpcError
    """

    params: type[msgspec.Struct]
    scope: str
    result: Any
    call: Callable[[Any], Awaitable[object]]


async def answer(data: bytes | str, methods: Mapping[str, Method], scopes: frozenset[str]) -> bytes | None:
    """The answer to one frame: a response, a batch of them, or None when everything was a notification."""
    try:
        request = msgspec.json.decode(data)
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError) as error:
        return _encode(_failure(None, RpcError(PARSE_ERROR, "parse error", str(error))))
    if not isinstance(request, list):
        response = await _answer_one(request, methods, scopes)
        return None if response is None else _encode(response)
    if not 0 < len(request) <= BATCH_MAX:
        problem = f"a batch has 1 to {BATCH_MAX} requests, this one {len(request)}"
        return _encode(_failure(None, RpcError(INVALID_REQUEST, "invalid request", problem)))
    responses = [await _answer_one(item, methods, scopes) for item in request]
    kept = [response for response in responses if response is not None]
    return _encode(kept) if kept else None


def notification(method: str, params: object) -> bytes:
    """A notification of the server: a request without an id."""
    return _encode({"jsonrpc": "2.0", "method": method, "params": params})


async def _answer_one(
    request: object, methods: Mapping[str, Method], scopes: frozenset[str]
) -> dict[str, object] | None:
    try:
        _check(request)
    except RpcError as error:
        return _failure(_id_of(request), error)
    assert isinstance(request, dict)
    try:
        result = await _call(request, methods, scopes)
    except RpcError as error:
        return _failure(request["id"], error) if "id" in request else None
    except DomainError as error:
        problem = RpcError(REFUSED, error.detail, {"code": error.code, "detail": error.detail})
        return _failure(request["id"], problem) if "id" in request else None
    return {"jsonrpc": "2.0", "id": request["id"], "result": result} if "id" in request else None


async def _call(request: dict[str, Any], methods: Mapping[str, Method], scopes: frozenset[str]) -> object:
    method = methods.get(request["method"])
    if method is None:
        names = ", ".join(sorted(methods))
        raise RpcError(METHOD_NOT_FOUND, f"no method is called {request['method'][:60]}", f"methods: {names}")
    if method.scope not in scopes:
        raise RpcError(SCOPE_MISSING, f"this token lacks the scope '{method.scope}'", {"scope": method.scope})
    return await method.call(_params(method.params, request.get("params", {})))


def _params(kind: type[msgspec.Struct], given: object) -> msgspec.Struct:
    names = kind.__struct_fields__
    if isinstance(given, list):
        if len(given) > len(names):
            raise RpcError(
                INVALID_PARAMS, "invalid params", f"at most {len(names)} are taken: {', '.join(names)}"
            )
        given = dict(zip(names, given, strict=False))
    try:
        return msgspec.convert(given, kind)
    except msgspec.ValidationError as error:
        raise RpcError(INVALID_PARAMS, "invalid params", str(error)) from error


def _check(request: object) -> None:
    if not isinstance(request, dict):
        raise RpcError(INVALID_REQUEST, "invalid request", "a request is an object")
    if request.get("jsonrpc") != "2.0":
        raise RpcError(INVALID_REQUEST, "invalid request", 'jsonrpc must be "2.0"')
    if not isinstance(request.get("method"), str):
        raise RpcError(INVALID_REQUEST, "invalid request", "method must be a string")
    if not isinstance(request.get("params", {}), (dict, list)):
        raise RpcError(INVALID_REQUEST, "invalid request", "params must be an object or an array")
    if "id" in request and not _is_id(request["id"]):
        raise RpcError(INVALID_REQUEST, "invalid request", "id must be a string, a number or null")


def _is_id(value: object) -> bool:
    return value is None or (isinstance(value, (str, int, float)) and not isinstance(value, bool))


def _id_of(request: object) -> object:
    value = request.get("id") if isinstance(request, dict) else None
    return value if _is_id(value) else None


def _failure(request_id: object, error: RpcError) -> dict[str, object]:
    body: dict[str, object] = {"code": error.number, "message": error.message}
    if error.data is not None:
        body["data"] = error.data
    return {"jsonrpc": "2.0", "id": request_id, "error": body}


def _encode(value: object) -> bytes:
    return msgspec.json.encode(value)
