"""Checks that a hello is signed by the vehicle's key for the nonce of this connection."""

import base64
import binascii

import msgspec
from cryptography.exceptions import InvalidSignature
from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PublicKey

from contract.wire.bounds import Id, Proof, ProtocolVersion
from contract.wire.close_reasons import CloseCode
from contract.wire.messages import OLDEST_PROTOCOL_VERSION, PROTOCOL_VERSION, Hello, signed_hello
from server.usecases.fleet.vehicle_sessions import HelloFacts


class HelloRefused(Exception):
    """The link is closed with `code`; `detail` names what was wrong with this hello."""

    def __init__(self, code: CloseCode, detail: str) -> None:
        super().__init__(detail)
        self.code: CloseCode = code
        self.detail = detail


class HelloClaim(msgspec.Struct, frozen=True):
    """The fields of a hello that its signature covers, and the signature."""

    protocol: ProtocolVersion
    vehicle_id: Id
    boot_id: Id
    nonce: Proof
    signature: Proof


def check_hello(hello: Hello | HelloClaim, nonce: str) -> None:
    """Check everything that does not need the key. Raises HelloRefused."""
    if not OLDEST_PROTOCOL_VERSION <= hello.protocol <= PROTOCOL_VERSION:
        raise HelloRefused(
            "protocol_version",
            f"protocol {hello.protocol} is not supported; versions {OLDEST_PROTOCOL_VERSION} to "
            f"{PROTOCOL_VERSION} are. Update the agent.",
        )
    if hello.nonce != nonce:
        raise HelloRefused(
            "nonce_wrong", "this hello answers another connection's challenge; sign the nonce of this one"
        )
    for name, value in (("vehicle_id", hello.vehicle_id), ("boot_id", hello.boot_id)):
        if not value:
            raise HelloRefused("malformed", f"{name} must not be empty")


def violation_of(hello: Hello) -> str:
    """What is wrong in the content of a hello whose fields are each within their bounds; "" for nothing."""
    if hello.wheelchair_places > hello.seats:
        return f"says it has {hello.wheelchair_places} wheelchair places and {hello.seats} seats"
    return ""


def claim_in(data: bytes | str) -> HelloClaim | None:
    """What a hello says of its sender, whatever else is wrong with it; None if it does not even say that."""
    try:
        return msgspec.json.decode(data, type=HelloClaim)
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError):
        return None


def verify_signature(hello: Hello | HelloClaim, public_key: bytes) -> None:
    """public_key: 32 raw bytes, as enrolled. Raises HelloRefused."""
    text = signed_hello(hello.nonce, hello.vehicle_id, hello.boot_id, hello.protocol)
    try:
        signature = base64.b64decode(hello.signature, validate=True)
        Ed25519PublicKey.from_public_bytes(public_key).verify(signature, text)
    except (binascii.Error, ValueError, InvalidSignature) as error:
        raise HelloRefused(
            "signature_wrong",
            f"the hello of {hello.vehicle_id} is not signed by its enrolled key; "
            "enrol the agent's present key with a new code",
        ) from error


def facts_of(hello: Hello) -> HelloFacts:
    """What the use case needs of a verified hello."""
    return HelloFacts(
        vehicle_id=hello.vehicle_id,
        boot_id=hello.boot_id,
        software=hello.software,
        stack=hello.stack,
        map_version=hello.map_version,
        logs=hello.event_logs,
        progress=hello.progress,
        seats=hello.seats,
        wheelchair_places=hello.wheelchair_places,
        run_boot_id=hello.run_boot_id,
        localizes_by=hello.localizes_by,
        localization_map=hello.localization_map,
    )
