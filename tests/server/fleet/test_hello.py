"""Which hellos are believed, each rule at its limit."""

import msgspec
import pytest

from contract.wire.messages import OLDEST_PROTOCOL_VERSION, PROTOCOL_VERSION, Hello
from server.fleet.hello import HelloRefused, check_hello, verify_signature, violation_of
from tests.server.fleet.vehicle_key import VehicleKeyPair, a_hello

NONCE = "nonce-1"
KEY = VehicleKeyPair("shuttle-1")


def changed(**changes: object) -> Hello:
    return msgspec.structs.replace(a_hello(NONCE), **changes)


def refused(hello: Hello) -> str:
    with pytest.raises(HelloRefused) as refusal:
        check_hello(hello, NONCE)
    return refusal.value.code


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"vehicle_id": "v", "boot_id": "b"},
        {"vehicle_id": 64 * "v", "boot_id": 64 * "b"},
        {"seats": 1, "wheelchair_places": 0},
        {"seats": 1, "wheelchair_places": 1},
        {"protocol": OLDEST_PROTOCOL_VERSION},
    ],
)
def test_a_hello_within_the_rules_is_taken(changes: dict[str, object]) -> None:
    check_hello(changed(**changes), NONCE)


@pytest.mark.parametrize(
    ("changes", "code"),
    [
        ({"vehicle_id": ""}, "malformed"),
        ({"boot_id": ""}, "malformed"),
        ({"nonce": "nonce-2"}, "nonce_wrong"),
        ({"protocol": OLDEST_PROTOCOL_VERSION - 1}, "protocol_version"),
        ({"protocol": PROTOCOL_VERSION + 1}, "protocol_version"),
    ],
)
def test_a_hello_beyond_a_rule_is_refused_by_its_name(changes: dict[str, object], code: str) -> None:
    assert refused(changed(**changes)) == code


@pytest.mark.parametrize(("seats", "places", "violates"), [(2, 2, False), (2, 3, True), (1, 0, False)])
def test_more_wheelchair_places_than_seats_break_the_protocol(
    seats: int, places: int, violates: bool
) -> None:
    assert bool(violation_of(changed(seats=seats, wheelchair_places=places))) is violates


def test_the_signature_of_the_enrolled_key_is_believed() -> None:
    verify_signature(a_hello(NONCE), KEY.public)


@pytest.mark.parametrize(
    "changes",
    [
        {"nonce": "nonce-2"},
        {"vehicle_id": "shuttle-2"},
        {"boot_id": "boot-2"},
        {"protocol": PROTOCOL_VERSION + 1},
        {"signature": ""},
        {"signature": "no base64 ü"},
        {"signature": KEY.sign(b"something else")},
    ],
)
def test_a_signature_of_anything_else_is_not(changes: dict[str, object]) -> None:
    with pytest.raises(HelloRefused) as refusal:
        verify_signature(changed(**changes), KEY.public)
    assert refusal.value.code == "signature_wrong"


def test_another_vehicles_key_signs_for_nobody_else() -> None:
    with pytest.raises(HelloRefused):
        verify_signature(a_hello(NONCE), VehicleKeyPair("shuttle-2").public)
