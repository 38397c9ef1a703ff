"""A vehicle's key and the hello it signs, for tests of the link."""

import base64

from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey

from contract.wire.messages import LATER_KINDS, PROTOCOL_VERSION, EventLogState, Hello, signed_hello


class VehicleKeyPair:
    """Deterministic: the same name gives the same key."""

    def __init__(self, name: str) -> None:
        self._private = Ed25519PrivateKey.from_private_bytes(name.encode().ljust(32, b"-")[:32])
        self.public: bytes = self._private.public_key().public_bytes_raw()

    @property
    def public_base64(self) -> str:
        return base64.b64encode(self.public).decode()

    def sign(self, text: bytes) -> str:
        return base64.b64encode(self._private.sign(text)).decode()


def a_hello(
    nonce: str,
    vehicle_id: str = "shuttle-1",
    boot_id: str = "boot-1",
    key: VehicleKeyPair | None = None,
    protocol: int = PROTOCOL_VERSION,
    map_version: str = "m1",
    logs: tuple[EventLogState, ...] = (),
    understands: tuple[str, ...] = LATER_KINDS,
) -> Hello:
    key = key or VehicleKeyPair(vehicle_id)
    return Hello(
        protocol=protocol,
        vehicle_id=vehicle_id,
        boot_id=boot_id,
        nonce=nonce,
        signature=key.sign(signed_hello(nonce, vehicle_id, boot_id, protocol)),
        software="0.1.0",
        stack="gem",
        map_version=map_version,
        vehicle_ns=1_000,
        event_logs=logs,
        understands=understands,
    )
