"""Writes the AsyncAPI documents of the four websockets from the code that speaks them.

python -m docs.protocol.build      # after a change of a message; a test keeps them equal
"""

import typing
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import msgspec
import yaml

from contract.wire.close_reasons import CLOSE_REASONS
from contract.wire.messages import (
    PROTOCOL_VERSION,
    PresenceRefused,
    PresenceReport,
    ServerMessage,
    VehicleMessage,
)
from server.api.sockets.developer_methods import DeveloperMethods, Subscriptions
from server.api.sockets.json_rpc import (
    INVALID_PARAMS,
    INVALID_REQUEST,
    METHOD_NOT_FOUND,
    PARSE_ERROR,
    REFUSED,
    SCOPE_MISSING,
)
from server.api.sockets.live import Refused, Watch
from server.live.scene import Delta, Snapshot

FOLDER = Path(__file__).parent
REF = "#/components/schemas/{name}"

VEHICLE_TEXT = f"""Protocol version {PROTOCOL_VERSION}. Text frames of JSON, one message each, tagged `type`.

The server speaks first (challenge). The vehicle answers with a hello whose signature is Ed25519 over
"campusloop-hello", the protocol version, the nonce, the vehicle id and the boot id, joined by line feeds.
One nonce opens one session once. After the welcome every frame carries its epoch; a newer session fences
the older. Events stay in the vehicle's outbox until events_acknowledged names a higher sequence; after a gap
the server names the event that it waits for. Before it closes, the server says goodbye with a code:

{{closings}}
"""
LIVE_TEXT = """The browser's first frame is a watch: with the ride's token for a passenger, without it for a
signed-in operator (session cookie). The server then sends a snapshot, deltas of whole vehicles and rides,
and another snapshot when the campus changes its map. A slow reader gets fewer, newer deltas. Pages of
another origin are refused. Before it closes, the server sends refused.
"""
DEVELOPER_TEXT = f"""JSON-RPC 2.0, batches and notifications included. Open it with the header
`Authorization: Bearer TOKEN`; tokens are made by operators and have the scopes read and drive. A revoked
token ends the connection at its next request with the notification `refused`.

Errors: {PARSE_ERROR} parse error, {INVALID_REQUEST} invalid request, {METHOD_NOT_FOUND} no such method,
{INVALID_PARAMS} invalid params, {REFUSED} refused by a rule of the house (data.code and data.detail as in the
REST API's problems), {SCOPE_MISSING} the token lacks the method's scope. After `subscribe`, the notifications
`vehicles` ({{at_ms, vehicles}}), `rides` ({{at_ms, rides}}) and `events` ({{vehicle_id, boot_id, sequence,
body}}) come unasked; vehicles and rides have the live view's shape.
"""


INFRASTRUCTURE_TEXT = """For cameras at crossings. Open it with the header `Authorization: Bearer TOKEN`; an
operator makes the token, with the scope infrastructure. The camera sends its word one to five times a second,
also when nobody is there; latest wins, nothing is acknowledged. A word is forwarded to the vehicles near the
area and to the consoles; after 2.5 s without one it counts for nothing. Vehicles slow down for people that a
camera tells of, and never go faster for its word that nobody is there than their own sensors allow.
"""


def documents() -> dict[str, str]:
    """File name -> YAML text."""
    return {
        "vehicle.asyncapi.yaml": _yaml(_vehicle()),
        "live.asyncapi.yaml": _yaml(_live()),
        "developer.asyncapi.yaml": _yaml(_developer()),
        "infrastructure.asyncapi.yaml": _yaml(_infrastructure()),
    }


def _vehicle() -> dict[str, Any]:
    closings = "\n".join(
        f"- `{row.code}` ({row.number}, retry {row.retry.replace('_', ' ')}): {row.advice}"
        for row in CLOSE_REASONS
    )
    text = VEHICLE_TEXT.format(closings=closings)
    received, sent = typing.get_args(VehicleMessage), typing.get_args(ServerMessage)
    return _document("Campusloop vehicle link", text, "/ws/vehicle", received, sent)


def _live() -> dict[str, Any]:
    return _document("Campusloop live view", LIVE_TEXT, "/ws/live", (Watch,), (Snapshot, Delta, Refused))


def _infrastructure() -> dict[str, Any]:
    return _document(
        "Campusloop infrastructure link",
        INFRASTRUCTURE_TEXT,
        "/ws/infrastructure",
        (PresenceReport,),
        (PresenceRefused,),
    )


def _developer() -> dict[str, Any]:
    # The table is built without services: only its shape is looked at.
    methods = DeveloperMethods(None, "", Subscriptions()).table()  # type: ignore[arg-type]
    kinds = {method.params for method in methods.values()}
    _, schemas = msgspec.json.schema_components(
        sorted(kinds, key=lambda kind: kind.__name__), ref_template=REF
    )
    messages = {
        name: {
            "name": name,
            "summary": f"Needs the scope {method.scope}.",
            "payload": {
                "type": "object",
                "required": ["jsonrpc", "method"],
                "properties": {
                    "jsonrpc": {"const": "2.0"},
                    "id": {"type": ["string", "number", "null"]},
                    "method": {"const": name},
                    "params": {"$ref": REF.format(name=method.params.__name__)},
                },
            },
        }
        for name, method in methods.items()
    }
    return _frame("Campusloop developer link", DEVELOPER_TEXT, "/ws/developer", messages, {}, schemas)


def _document(
    title: str, text: str, address: str, received: Sequence[Any], sent: Sequence[Any]
) -> dict[str, Any]:
    _, schemas = msgspec.json.schema_components([*received, *sent], ref_template=REF)
    return _frame(title, text, address, _messages(received), _messages(sent), schemas)


def _messages(kinds: Sequence[Any]) -> dict[str, Any]:
    return {
        str(kind.__struct_config__.tag or kind.__name__.lower()): {
            "name": kind.__name__,
            "summary": " ".join((kind.__doc__ or "").split()),
            "payload": {"$ref": REF.format(name=kind.__name__)},
        }
        for kind in kinds
    }


def _frame(
    title: str,
    text: str,
    address: str,
    received: Mapping[str, Any],
    sent: Mapping[str, Any],
    schemas: Mapping[str, Any],
) -> dict[str, Any]:
    """received and sent as the server sees them."""
    operations = {"receive": ("receive", received), "send": ("send", sent)}
    return {
        "asyncapi": "3.0.0",
        "info": {"title": title, "version": f"{PROTOCOL_VERSION}.0.0", "description": text},
        "defaultContentType": "application/json",
        "channels": {
            "socket": {
                "address": address,
                "messages": {
                    name: {"$ref": f"#/components/messages/{name}"} for name in sorted({**received, **sent})
                },
            }
        },
        "operations": {
            name: {
                "action": action,
                "channel": {"$ref": "#/channels/socket"},
                "messages": [{"$ref": f"#/channels/socket/messages/{message}"} for message in messages],
            }
            for name, (action, messages) in operations.items()
            if messages
        },
        "components": {
            "messages": dict(sorted({**received, **sent}.items())),
            "schemas": dict(sorted(schemas.items())),
        },
    }


class _Dumper(yaml.SafeDumper):
    """Keeps the lines of texts."""


def _text(dumper: yaml.SafeDumper, text: str) -> yaml.ScalarNode:
    style = "|" if "\n" in text else None
    return dumper.represent_scalar("tag:yaml.org,2002:str", text, style=style)


_Dumper.add_representer(str, _text)


def _yaml(document: dict[str, Any]) -> str:
    text: str = yaml.dump(document, Dumper=_Dumper, sort_keys=False, allow_unicode=True, width=110)
    return text


if __name__ == "__main__":
    for name, text in documents().items():
        (FOLDER / name).write_text(text, encoding="utf-8")
