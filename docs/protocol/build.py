"""Writes the AsyncAPI documents of the four websockets from the code that speaks them.

python -m docs.protocol.build      # after a change of a message; a test keeps them equal
"""

import typing
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import yaml

from contract.wire.close_reasons import CLOSE_REASONS
from contract.wire.messages import (
    PROTOCOL_VERSION,
    PresenceRefused,
    PresenceReport,
    ServerMessage,
    VehicleMessage,
)
from docs.protocol import developer
from docs.protocol.asyncapi import Operation, Socket, document, message, schemas_of, text_of
from server.api.sockets.live import Refused, Watch
from server.live.scene import Delta, Snapshot

FOLDER = Path(__file__).parent
VEHICLE_VERSION = f"{PROTOCOL_VERSION}.0.0"
# Of the sockets that speak no version: nothing in them has been broken so far.
SOCKET_VERSION = "1.0.0"

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
INFRASTRUCTURE_TOKEN = "A token with the scope infrastructure, made by an operator."
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
        "developer.asyncapi.yaml": _yaml(document(developer.socket())),
        "infrastructure.asyncapi.yaml": _yaml(_infrastructure()),
    }


def _vehicle() -> dict[str, Any]:
    closings = "\n".join(
        f"- `{row.code}` ({row.number}, retry {row.retry.replace('_', ' ')}): {row.advice}"
        for row in CLOSE_REASONS
    )
    text = VEHICLE_TEXT.format(closings=closings)
    received, sent = typing.get_args(VehicleMessage), typing.get_args(ServerMessage)
    return _of_structs(
        "Campusloop vehicle link", text, "/ws/vehicle", received, sent, version=VEHICLE_VERSION
    )


def _live() -> dict[str, Any]:
    return _of_structs("Campusloop live view", LIVE_TEXT, "/ws/live", (Watch,), (Snapshot, Delta, Refused))


def _infrastructure() -> dict[str, Any]:
    return _of_structs(
        "Campusloop infrastructure link",
        INFRASTRUCTURE_TEXT,
        "/ws/infrastructure",
        (PresenceReport,),
        (PresenceRefused,),
        INFRASTRUCTURE_TOKEN,
    )


def _of_structs(
    title: str,
    text: str,
    address: str,
    received: Sequence[Any],
    sent: Sequence[Any],
    bearer: str = "",
    version: str = SOCKET_VERSION,
) -> dict[str, Any]:
    """received and sent as the server sees them."""
    _, schemas = schemas_of([*received, *sent])
    operations = {
        name: Operation(name, [_name(kind) for kind in kinds])
        for name, kinds in (("receive", received), ("send", sent))
    }
    messages = {
        _name(kind): message(kind.__name__, text_of(kind), {"$ref": f"#/components/schemas/{kind.__name__}"})
        for kind in (*received, *sent)
    }
    return document(Socket(title, version, text, address, messages, operations, schemas, bearer))


def _name(kind: Any) -> str:
    return str(kind.__struct_config__.tag or kind.__name__.lower())


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
