"""Enrols the vehicles of a benchmark in the database of a server that does not run yet."""

import asyncio
import base64
import hashlib
from collections.abc import Mapping
from dataclasses import replace

from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey

from benchmarks.ingest.messages import BOOT
from server.live_ports import live_ports
from server.settings import settings_from
from server.usecases.fleet import vehicles
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record import identity

_AT_A_TIME = 100


def vehicle_name(number: int) -> str:
    return f"vehicle-{number + 1}"


def vehicle_key(number: int) -> Ed25519PrivateKey:
    """The same in every run."""
    seed = hashlib.sha256(f"benchmark vehicle {number}".encode()).digest()
    return Ed25519PrivateKey.from_private_bytes(seed)


def enrol_fleet(environment: Mapping[str, str], count: int, serving: int = 0) -> None:
    """Migrate the database, load the map, and enrol the vehicles: by a code each, like every vehicle.

    They count as placed on the road, since no operator places them here. The first `serving` ones count as
    resumed by an operator instead, and are placed by the first position that they report.
    """
    asyncio.run(_enrol(environment, count, serving))


async def _enrol(environment: Mapping[str, str], count: int, serving: int) -> None:
    live = await live_ports(settings_from(environment))
    try:
        for first in range(0, count, _AT_A_TIME):
            numbers = range(first, min(first + _AT_A_TIME, count))
            await asyncio.gather(
                *(
                    live.ports.transactions.run(_enrolling(number, serves=number < serving))
                    for number in numbers
                )
            )
    finally:
        await live.ports.close()


def _enrolling(number: int, *, serves: bool):  # type: ignore[no-untyped-def]
    vehicle_id = vehicle_name(number)
    public_key = base64.b64encode(vehicle_key(number).public_key().public_bytes_raw()).decode()

    def work(uow: UnitOfWork) -> None:
        code = identity.create_enrolment_code(
            uow, vehicle_id, vehicle_id, "benchmark", seats=6, wheelchair_places=1
        )
        vehicle = vehicles.enrol(uow, code, vehicle_id, public_key)
        if serves:
            uow.vehicles.save(replace(vehicle, held=False, mode="autonomous", boot_id=BOOT))
        else:
            uow.vehicles.save(replace(vehicle, placed=True))

    return work
