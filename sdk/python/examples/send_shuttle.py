"""List the shuttles, send one to a stop, and follow it until it stands there.

export CAMPUSLOOP_TOKEN=...     # made in the console, scopes read and drive
python sdk/python/examples/send_shuttle.py http://127.0.0.1:8080 --list
python sdk/python/examples/send_shuttle.py http://127.0.0.1:8080 --stop stop-5
"""

import argparse
import asyncio
import os
import ssl
import sys

from campusloop_sdk import Campus, CampusError, Live, Vehicle, VehiclesUpdate, connect


async def list_stops(campus: Campus) -> None:
    async for stop in campus.stops():
        print(f"{stop.stop_id:10} {stop.name_en or stop.name}")


async def send_shuttle(campus: Campus, stop_id: str, vehicle_id: str | None, only_try: bool) -> None:
    vehicles = [vehicle async for vehicle in campus.vehicles.list()]
    for vehicle in vehicles:
        where = "connected" if vehicle.connected else "away"
        print(f"{vehicle.vehicle_id:12} {where:10} {vehicle.mode:12} visits ahead: {len(vehicle.visits)}")
    chosen = vehicle_id or free_shuttle(vehicles)
    planned = await campus.vehicles.send(chosen, stop_id, dry_run=True)
    visit = planned.last_visit_to(stop_id)
    if only_try or visit is None:
        print(f"{chosen} would visit {stop_id}" + (f", expected {visit.eta}" if visit else ""))
        return
    # Subscribed before the command, so that no change is missed.
    async with campus.live("vehicles") as live:
        sent = (await campus.vehicles.send(chosen, stop_id)).last_visit_to(stop_id)
        if sent is None:
            sys.exit(f"{chosen} has been there already")
        print(f"{chosen} will visit {stop_id} (visit {sent.visit_id}, expected {sent.eta})")
        await follow(live, chosen, sent.visit_id)


def free_shuttle(vehicles: list[Vehicle]) -> str:
    """The first connected one in service with the fewest visits ahead."""
    able = [one for one in vehicles if one.connected and one.in_service and not one.held]
    if not able:
        sys.exit("no shuttle is connected and free to drive; resume one in the console")
    return min(able, key=lambda one: (len(one.visits), one.vehicle_id)).vehicle_id


async def follow(live: Live, vehicle_id: str, visit_id: str) -> None:
    """Until the visit is under way: the shuttle stands at the stop. Or until it is no longer planned."""
    was_planned = False
    async for update in live:
        vehicle = live.vehicles.get(vehicle_id)
        if not isinstance(update, VehiclesUpdate) or vehicle is None:
            continue
        if vehicle.status is not None:
            pose = vehicle.status.pose_map
            print(f"\r{pose.x_m:8.1f} {pose.y_m:8.1f} m", end="", flush=True)
        visit = vehicle.visit(visit_id)
        if visit is not None and visit.state == "pending":
            was_planned = True
        elif visit is not None or was_planned:
            print(f"\n{vehicle_id}: visit {visit.state if visit else 'over'}")
            return


def tls_context(certificate: str | None) -> ssl.SSLContext | None:
    return None if certificate is None else ssl.create_default_context(cafile=certificate)


async def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("server", help="http(s)://HOST:PORT")
    what = parser.add_mutually_exclusive_group(required=True)
    what.add_argument("--list", action="store_true", help="list the stops")
    what.add_argument("--stop", help="the stop_id to send a shuttle to")
    parser.add_argument("--vehicle", help="vehicle_id; left out: a free one")
    parser.add_argument("--dry-run", action="store_true", help="only say what it would do")
    parser.add_argument("--certificate", help="PEM file of a server with a self-signed certificate")
    arguments = parser.parse_args()
    token = os.environ.get("CAMPUSLOOP_TOKEN")
    if not token:
        sys.exit("set CAMPUSLOOP_TOKEN to a developer token made in the console")
    try:
        async with connect(arguments.server, token, tls=tls_context(arguments.certificate)) as campus:
            if arguments.list:
                await list_stops(campus)
            else:
                await send_shuttle(campus, arguments.stop, arguments.vehicle, arguments.dry_run)
    except CampusError as error:
        sys.exit(f"{arguments.server}: {error}")


if __name__ == "__main__":
    asyncio.run(main())
