"""Rides, vehicles and closures: the calls of a campus. Each may raise what `errors` lists."""

from collections.abc import AsyncIterator, Sequence
from datetime import datetime
from typing import TypeVar
from urllib.parse import quote

from campusloop_sdk.models import (
    BookedRide,
    Closure,
    Offer,
    Ride,
    RideState,
    Vehicle,
    VehicleCommand,
    VehicleRecord,
)
from campusloop_sdk.rest import Params, Rest

T = TypeVar("T")
PAGE = 200


class Rides:
    """key: names a command across repeats; the same key twice gives the first answer."""

    def __init__(self, rest: Rest) -> None:
        self._rest = rest

    def list(
        self,
        states: Sequence[RideState] | None = None,
        vehicle_id: str | None = None,
        page: int = PAGE,
        *,
        ride_code: str | None = None,
    ) -> AsyncIterator[Ride]:
        """Newest request first, read page by page. Scope `read`.

        ride_code  six characters that passengers say aloud; a later ride may get the code of one that ended
        """
        params: Params = {"state": states, "vehicle_id": vehicle_id, "limit": page, "code": ride_code}
        return self._rest.listed("/rides", Ride, params)

    async def get(self, ride_id: str) -> Ride:
        """Scope `read`."""
        return await self._rest.get(f"/rides/id/{_step(ride_id)}", Ride)

    async def book(
        self,
        from_stop: str,
        to_stop: str,
        *,
        party: int = 1,
        wheelchairs: int = 0,
        earliest: datetime | None = None,
        may_walk: bool = False,
        key: str | None = None,
    ) -> BookedRide:
        """Answered at once: with a vehicle and a promise, or in state `refused` with the rule that binds.

        earliest  aware; None: now. Scope `drive`.
        """
        body = {
            "from_stop": from_stop,
            "to_stop": to_stop,
            "party": party,
            "wheelchairs": wheelchairs,
            "earliest": earliest,
            "may_walk": may_walk,
        }
        return await self._rest.command("POST", "/rides", BookedRide, body=body, key=key)

    async def look(
        self,
        from_stop: str,
        to_stop: str,
        *,
        party: int = 1,
        wheelchairs: int = 0,
        earliest: datetime | None = None,
    ) -> Offer:
        """What a booking would get now. Nothing is reserved or stored."""
        body = {
            "from_stop": from_stop,
            "to_stop": to_stop,
            "party": party,
            "wheelchairs": wheelchairs,
            "earliest": earliest,
        }
        return await self._rest.command("POST", "/rides/offers", Offer, body=body)

    async def cancel(self, ride_id: str, *, key: str | None = None) -> Ride:
        """A party aboard is let out as soon as possible. Scope `drive`."""
        return await self._rest.command("POST", f"/rides/id/{_step(ride_id)}/cancel", Ride, key=key)

    async def change_destination(self, ride_id: str, to_stop: str, *, key: str | None = None) -> Ride:
        """Refused if it would break another promise. Scope `drive`."""
        path = f"/rides/id/{_step(ride_id)}/destination"
        return await self._rest.command("POST", path, Ride, body={"to_stop": to_stop}, key=key)


class Vehicles:
    """key: names a command across repeats; the same key twice gives the first answer."""

    def __init__(self, rest: Rest) -> None:
        self._rest = rest

    def list(self, page: int = PAGE) -> AsyncIterator[Vehicle]:
        """By id, read page by page. Scope `read`."""
        return self._rest.listed("/vehicles", Vehicle, {"limit": page})

    async def get(self, vehicle_id: str) -> Vehicle:
        """Scope `read`."""
        return await self._rest.get(f"/vehicles/{_step(vehicle_id)}", Vehicle)

    async def send(
        self, vehicle_id: str, stop_id: str, *, dry_run: bool = False, key: str | None = None
    ) -> Vehicle:
        """Let it visit a stop, at the first chance that keeps every promise: the vehicle with its new plan.

        dry_run  only answer what it would do. Scope `drive`.
        """
        params: Params = {"stop_id": stop_id, "dry_run": dry_run}
        path = f"/vehicles/{_step(vehicle_id)}/send"
        return await self._rest.command("POST", path, Vehicle, params=params, key=key)

    async def hold(
        self, vehicle_id: str, *, for_s: float | None = None, key: str | None = None
    ) -> VehicleCommand:
        """A comfortable stand, until resumed or for a time. Scope `drive`."""
        return await self._command(vehicle_id, "hold", VehicleCommand, {"for_s": for_s}, key)

    async def resume(self, vehicle_id: str, *, key: str | None = None) -> VehicleCommand:
        """Release a held vehicle. Scope `drive`."""
        return await self._command(vehicle_id, "resume", VehicleCommand, {}, key)

    async def stop_now(self, vehicle_id: str, *, key: str | None = None) -> VehicleCommand:
        """Stop as hard as is safe, and stay held. Scope `drive`."""
        return await self._command(vehicle_id, "stop-now", VehicleCommand, {}, key)

    async def announce(self, vehicle_id: str, text: str, *, key: str | None = None) -> VehicleCommand:
        """Say a text aloud in the vehicle and show it on its screen. Scope `drive`."""
        path = f"/vehicles/{_step(vehicle_id)}/announce"
        return await self._rest.command("POST", path, VehicleCommand, body={"text": text}, key=key)

    async def recall(self, vehicle_id: str, *, key: str | None = None) -> VehicleRecord:
        """Take it out of service: it first takes its riders to their stops. Scope `drive`."""
        return await self._command(vehicle_id, "recall", VehicleRecord, {}, key)

    async def release(self, vehicle_id: str, *, key: str | None = None) -> VehicleRecord:
        """Put a recalled vehicle back into service. Scope `drive`."""
        return await self._command(vehicle_id, "release", VehicleRecord, {}, key)

    async def _command(self, vehicle_id: str, name: str, kind: type[T], params: Params, key: str | None) -> T:
        path = f"/vehicles/{_step(vehicle_id)}/{name}"
        return await self._rest.command("POST", path, kind, params=params, key=key)


class Closures:
    """Roads that no vehicle is sent through."""

    def __init__(self, rest: Rest) -> None:
        self._rest = rest

    def list(self, page: int = PAGE) -> AsyncIterator[Closure]:
        """Those that hold now and those to come, by their beginning. Scope `read`."""
        return self._rest.listed("/closures", Closure, {"limit": page})

    async def close(
        self,
        lane_ids: Sequence[str] = (),
        *,
        section_ids: Sequence[str] = (),
        reason: str = "",
        starts_at: datetime | None = None,
        ends_at: datetime | None = None,
        key: str | None = None,
    ) -> Closure:
        """starts_at None: now; ends_at None: until it is lifted. Scope `drive`."""
        body = {
            "lane_ids": list(lane_ids),
            "section_ids": list(section_ids),
            "reason": reason,
            "starts_at": starts_at,
            "ends_at": ends_at,
        }
        return await self._rest.command("POST", "/closures", Closure, body=body, key=key)

    async def lift(self, closure_id: str, *, key: str | None = None) -> None:
        """Open the road again. Scope `drive`."""
        await self._rest.command("DELETE", f"/closures/{_step(closure_id)}", type(None), key=key)


def _step(value: str) -> str:
    """An id as one step of a path."""
    return quote(value, safe="")
