"""The developer socket as AsyncAPI: JSON-RPC 2.0 requests, their responses and errors, and notifications."""

from typing import Any

from docs.protocol.asyncapi import REF, Operation, Socket, message, schemas_of, text_of
from server.api.security.access import Actor
from server.api.sockets.developer_messages import NOTIFICATIONS
from server.api.sockets.developer_methods import DeveloperMethods, Subscriptions
from server.api.sockets.json_rpc import (
    BATCH_MAX,
    INVALID_PARAMS,
    INVALID_REQUEST,
    METHOD_NOT_FOUND,
    PARSE_ERROR,
    REFUSED,
    SCOPE_MISSING,
    Method,
)

VERSION = "1.0.0"
TOKEN = "Made by an operator, with the scopes read and drive."
TEXT = f"""JSON-RPC 2.0, batches of up to {BATCH_MAX} requests and notifications included. Open it with the
header `Authorization: Bearer TOKEN`; tokens are made by operators and have the scopes read and drive. A
revoked or expired token ends the connection with the notification `refused`.

A response has the request's id and either `result` or `error`. After `subscribe`, the notifications of the
topics come unasked. `vehicles` and `rides` begin with a snapshot; then come whole vehicles and rides that
changed. After a lost connection, open another one and subscribe again: the snapshot has what was missed.
A command with an `idempotency_key` is carried out once; a repeat within a day gets the first answer.
"""
ID = {"type": ["string", "number", "null"], "description": "The request's; null if it could not be read."}
# Number -> meaning, and the schema of `data`.
ERRORS: dict[int, tuple[str, dict[str, Any]]] = {
    PARSE_ERROR: ("The frame is not JSON.", {"type": "string"}),
    INVALID_REQUEST: ("Not a JSON-RPC request.", {"type": "string"}),
    METHOD_NOT_FOUND: ("No method has this name; data lists them.", {"type": "string"}),
    INVALID_PARAMS: ("The params do not fit the method.", {"type": "string"}),
    REFUSED: (
        "Refused by a rule; code and detail as in the REST API's problems.",
        {
            "type": "object",
            "required": ["code", "detail"],
            "properties": {"code": {"type": "string"}, "detail": {"type": "string"}},
        },
    ),
    SCOPE_MISSING: (
        "The token lacks the method's scope.",
        {"type": "object", "required": ["scope"], "properties": {"scope": {"type": "string"}}},
    ),
}
ERROR = "error"


def socket() -> Socket:
    methods = _methods()
    kinds = [method.params for method in methods.values()]
    results, schemas = schemas_of([*kinds, *NOTIFICATIONS.values(), *(m.result for m in methods.values())])
    results = results[len(kinds) + len(NOTIFICATIONS) :]
    messages: dict[str, Any] = {ERROR: _error()}
    operations: dict[str, Operation] = {}
    for (name, method), result in zip(methods.items(), results, strict=True):
        messages[name] = _request(name, method)
        messages[f"{name}_result"] = _response(name, result)
        operations[name] = Operation("receive", [name], [f"{name}_result", ERROR], f"Scope {method.scope}.")
    for name, kind in NOTIFICATIONS.items():
        messages[f"{name}_notification"] = _notification(name, kind)
    operations["notify"] = Operation("send", [f"{name}_notification" for name in NOTIFICATIONS])
    title, address = "Campusloop developer link", "/ws/developer"
    return Socket(title, VERSION, TEXT, address, messages, operations, schemas, TOKEN)


def _methods() -> dict[str, Method]:
    # The table is built without services: only its shape is looked at.
    unnamed = Actor("developer", "", "")
    return DeveloperMethods(None, unnamed, Subscriptions()).table()  # type: ignore[arg-type]


def _request(name: str, method: Method) -> dict[str, Any]:
    text = f"Needs the scope {method.scope}. {text_of(method.params)}"
    params = {"$ref": REF.format(name=method.params.__name__)}
    optional = {"id": {**ID, "description": "Without it, there is no answer."}, "params": params}
    return message(name, text, _frame({"method": {"const": name}}, optional))


def _response(name: str, result: dict[str, Any]) -> dict[str, Any]:
    return message(f"{name}_result", f"The answer to {name}.", _frame({"id": ID, "result": result}))


def _notification(name: str, kind: Any) -> dict[str, Any]:
    params = {"$ref": REF.format(name=kind.__name__)}
    return message(name, text_of(kind), _frame({"method": {"const": name}, "params": params}))


def _error() -> dict[str, Any]:
    kinds = [
        {
            "type": "object",
            "description": meaning,
            "required": ["code", "message"],
            "properties": {"code": {"const": number}, "message": {"type": "string"}, "data": data},
        }
        for number, (meaning, data) in ERRORS.items()
    ]
    return message(
        ERROR, "The answer to a request that failed.", _frame({"id": ID, "error": {"oneOf": kinds}})
    )


def _frame(required: dict[str, Any], optional: dict[str, Any] | None = None) -> dict[str, Any]:
    """A JSON-RPC object with these members."""
    return {
        "type": "object",
        "required": ["jsonrpc", *required],
        "properties": {"jsonrpc": {"const": "2.0"}, **required, **(optional or {})},
    }
