"""The frame of an AsyncAPI 3 document: server, security, channel, operations and their replies."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import msgspec

VERSION = "3.1.0"
REF = "#/components/schemas/{name}"
BEARER = "developerToken"


@dataclass(frozen=True, slots=True)
class Operation:
    """What goes one way over the socket, as the server sees it.

    messages  those of the channel that it is about, by name
    replies   those that answer it, by name
    """

    action: str
    messages: Sequence[str]
    replies: Sequence[str] = ()
    summary: str = ""


@dataclass(frozen=True, slots=True)
class Socket:
    """One document. messages and schemas: by name; bearer: it is opened with a developer token."""

    title: str
    version: str
    text: str
    address: str
    messages: Mapping[str, Any]
    operations: Mapping[str, Operation]
    schemas: Mapping[str, Any]
    bearer: str = ""
    more: Mapping[str, Any] = field(default_factory=dict)


def document(socket: Socket) -> dict[str, Any]:
    components = {
        "messages": dict(sorted(socket.messages.items())),
        "schemas": dict(sorted(_without_discriminators(socket.schemas).items())),
    }
    if socket.bearer:
        components["securitySchemes"] = {
            BEARER: {"type": "http", "scheme": "bearer", "description": socket.bearer}
        }
    return {
        "asyncapi": VERSION,
        "info": {
            "title": socket.title,
            "version": socket.version,
            "description": socket.text,
            "license": {"name": "Apache-2.0", "url": "https://www.apache.org/licenses/LICENSE-2.0"},
        },
        "defaultContentType": "application/json",
        "servers": {"campus": _server(bool(socket.bearer))},
        "channels": {
            "socket": {
                "address": socket.address,
                "messages": {
                    name: {"$ref": f"#/components/messages/{name}"} for name in sorted(socket.messages)
                },
            }
        },
        "operations": {name: _operation(one) for name, one in socket.operations.items()},
        "components": components,
    }


def schemas_of(kinds: Sequence[Any]) -> tuple[list[dict[str, Any]], dict[str, Any]]:
    """The schema of each type, and those that they refer to by name."""
    own, schemas = msgspec.json.schema_components(kinds, ref_template=REF)
    return list(own), schemas


def message(name: str, summary: str, payload: Mapping[str, Any]) -> dict[str, Any]:
    return {"name": name, "summary": summary, "payload": payload}


def text_of(kind: Any) -> str:
    """The type's docstring on one line."""
    return " ".join((kind.__doc__ or "").split())


def _server(has_bearer: bool) -> dict[str, Any]:
    server: dict[str, Any] = {
        "host": "{host}",
        "protocol": "ws",
        "description": "With TLS (any address but this machine's own) the protocol is wss.",
        "variables": {"host": {"default": "127.0.0.1:8080", "description": "Host and port of the server."}},
    }
    if has_bearer:
        server["security"] = [{"$ref": f"#/components/securitySchemes/{BEARER}"}]
    return server


def _operation(operation: Operation) -> dict[str, Any]:
    made: dict[str, Any] = {"action": operation.action, "channel": {"$ref": "#/channels/socket"}}
    if operation.summary:
        made["summary"] = operation.summary
    made["messages"] = [_in_channel(name) for name in operation.messages]
    if operation.replies:
        made["reply"] = {
            "channel": {"$ref": "#/channels/socket"},
            "messages": [_in_channel(name) for name in operation.replies],
        }
    return made


def _in_channel(name: str) -> dict[str, str]:
    return {"$ref": f"#/channels/socket/messages/{name}"}


def _without_discriminators(node: Any) -> Any:
    """The schemas with plain alternatives.

    AsyncAPI's discriminator takes names of schemas, and ours are tags. Every alternative has its tag as the
    only allowed value, so that exactly one fits.
    """
    if isinstance(node, Mapping):
        kept = {
            name: _without_discriminators(value) for name, value in node.items() if name != "discriminator"
        }
        if "discriminator" in node and isinstance(node["discriminator"], Mapping) and "anyOf" in kept:
            kept["oneOf"] = kept.pop("anyOf")
        return kept
    if isinstance(node, list):
        return [_without_discriminators(value) for value in node]
    return node
