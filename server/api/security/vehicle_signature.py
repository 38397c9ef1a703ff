"""Requests over HTTP that a vehicle signs with its key, as it signs the hello of its link."""

import base64
import binascii
from typing import Annotated

from cryptography.exceptions import InvalidSignature
from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PublicKey
from fastapi import Header

from contract.wire.upload import SIGNATURE_HEADER
from server.api.formats import NAME_PATTERN
from server.api.problems import SignatureWrong
from server.api.services import Services
from server.usecases.fleet import vehicles

SigningVehicle = Annotated[str, Header(alias="Vehicle-Id", pattern=NAME_PATTERN, examples=["shuttle-1"])]
Signature = Annotated[
    str,
    Header(
        alias=SIGNATURE_HEADER,
        max_length=128,
        pattern=r"^[\x21-\x7e]+$",
        description="Base64 of the Ed25519 signature over the kind of request ('campusloop-segment', "
        "'campusloop-map', 'campusloop-localization-map', 'campusloop-scans'), the vehicle id, and the hash "
        "or version, one a line.",
    ),
]


async def check_signature(services: Services, vehicle_id: str, signature: str, signed: bytes) -> None:
    """signed: the bytes that the vehicle's enrolled key must have signed.

    Raises KeyUnknown, VehicleUnknown, SignatureWrong.
    """
    key = await services.transactions.read(lambda uow: vehicles.key_of(uow, vehicle_id))
    try:
        raw = base64.b64decode(signature, validate=True)
        Ed25519PublicKey.from_public_bytes(base64.b64decode(key)).verify(raw, signed)
    except (binascii.Error, ValueError, InvalidSignature) as error:
        raise SignatureWrong(f"the request is not signed by the enrolled key of {vehicle_id}") from error
