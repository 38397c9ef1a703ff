"""Messages of the websockets, made from their AsyncAPI documents: valid, at the bounds, and broken."""

import json
import random
from collections import defaultdict
from collections.abc import Callable, Iterator
from typing import Any

import schemathesis
import yaml

from benchmarks.attacks.generation import cases
from docs.protocol.build import documents

_MADE_AT_A_TIME = 50
# What is beyond every bound or none of its kind; JSON numbers that no encoder writes are raw text.
_ODD: tuple[Any, ...] = (
    "",
    "x" * 300,
    "x" * 70_000,
    "\x00",
    "\ud800",
    -1,
    0,
    1 << 31,
    (1 << 63) - 1,
    -(1 << 63),
    1 << 64,
    1 << 70,
    1e308,
    -1e308,
    5e-324,
    -0.0,
    None,
    True,
    [],
    {},
    [[]] * 40,
    "2026-02-30T00:00:00Z",
    "9999-12-31T23:59:59-14:00",
)
_RAW: tuple[bytes, ...] = (
    b"",
    b"{",
    b"[]",
    b"null",
    b"\xff\xfe",
    b"[" * 20_000,
    b'{"type":' * 2_000,
    b" " * 600_000,
    b'{"type":"status","speed_mps":1e400}',
    b'{"jsonrpc":"2.0","id":1e400,"method":"list_stops"}',
    b'{"type":"hello","type":"status"}',
)


class SocketMessages:
    """`next` draws a message that the server of a socket may receive; address: the socket's path."""

    def __init__(self, rng: random.Random) -> None:
        self._rng = rng
        self._made: dict[tuple[str, str], Iterator[Any]] = {}
        self._operations: dict[str, dict[str, Any]] = defaultdict(dict)
        for text in documents().values():
            document = yaml.safe_load(text)
            address = document["channels"]["socket"]["address"]
            paths = {f"/{name}": _path(document, name) for name in _received(document)}
            described = {
                "openapi": "3.1.0",
                "info": {"title": address, "version": "1"},
                "paths": paths,
                "components": {"schemas": document["components"]["schemas"]},
            }
            for one in schemathesis.openapi.from_dict(described).get_all_operations():
                operation = one.ok()
                self._operations[address][operation.path.removeprefix("/")] = operation

    @property
    def addresses(self) -> tuple[str, ...]:
        return tuple(self._operations)

    def names(self, address: str) -> tuple[str, ...]:
        return tuple(self._operations[address])

    def valid(self, address: str, name: str) -> Any:
        """A new value of the message's schema."""
        known = self._made.get((address, name))
        found = None if known is None else next(known, None)
        while found is None:
            operation = self._operations[address][name]
            made = cases(operation, self._rng.getrandbits(32), _MADE_AT_A_TIME)
            known = self._made[address, name] = iter([json.loads(json.dumps(case.body)) for case in made])
            found = next(known, None)
        return found

    def next(self, address: str, fill: Callable[[str, Any], Any]) -> bytes:
        """fill: gives a valid message, by its name, the ids and numbers of the open session"""
        if self._rng.random() < 0.05:
            return self._rng.choice(_RAW)
        name = self._rng.choice(self.names(address))
        value = fill(name, self.valid(address, name))
        for _ in range(self._rng.choice((0, 0, 1, 1, 2, 5))):
            value = self._mutated(value)
        data = json.dumps(value).encode("utf-8", "surrogatepass")
        return data[: self._rng.randrange(len(data))] if self._rng.random() < 0.03 else data

    def _mutated(self, value: Any) -> Any:
        """One thing somewhere inside is replaced, removed or added."""
        rng = self._rng
        if isinstance(value, dict) and value and rng.random() < 0.85:
            name = rng.choice(list(value))
            change = rng.random()
            if change < 0.1:
                return {key: one for key, one in value.items() if key != name}
            if change < 0.15:
                return {**value, "extra": rng.choice(_ODD)}
            return {**value, name: self._mutated(value[name])}
        if isinstance(value, list) and value and rng.random() < 0.7:
            number = rng.randrange(len(value))
            if rng.random() < 0.1:
                return [*value, *value]
            return [*value[:number], self._mutated(value[number]), *value[number + 1 :]]
        return rng.choice(_ODD)


def _received(document: dict[str, Any]) -> list[str]:
    """The messages that the server receives, by name."""
    return [
        message["$ref"].rsplit("/", 1)[-1]
        for operation in document["operations"].values()
        if operation["action"] == "receive"
        for message in operation["messages"]
    ]


def _path(document: dict[str, Any], name: str) -> dict[str, Any]:
    """An operation whose body is the message: so the generator of the REST fuzz makes it."""
    payload = document["components"]["messages"][name]["payload"]
    content = {"application/json": {"schema": payload}}
    return {
        "post": {
            "operationId": name,
            "requestBody": {"required": True, "content": content},
            "responses": {"200": {"description": "-"}},
        }
    }
