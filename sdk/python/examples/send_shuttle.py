"""List the shuttles, send one to a stop, and follow it until it stands there.

export CAMPUSLOOP_TOKEN=...     # made in the console, scopes read and drive
python sdk/python/examples/send_shuttle.py http://127.0.0.1:8080 --stop stop-5

GET /api/v1/stops lists the ids of the stops.
"""

import argparse
import asyncio
import os
import sys

from campusloop_sdk import Campus, ConnectionLost, RequestRefused, Shuttle, VehicleFacts, connect


async def send_shuttle(campus: Campus, stop_id: str, vehicle_id: str | None) -> None:
    shuttles = await campus.list_vehicles()
    for shuttle in shuttles:
        print(f"{shuttle.vehicle_id:12} {shuttle.facts.mode:12} next stop: {shuttle.task.next_stop or '-'}")
    chosen = vehicle_id or free_shuttle(shuttles)
    await campus.subscribe("vehicles", "events")
    sent = await campus.send_to_stop(chosen, stop_id)
    print(f"{chosen} will visit {stop_id} (visit {sent.visit_id}, expected {sent.eta})")
    await follow(campus, chosen, sent.visit_id)


def free_shuttle(shuttles: list[Shuttle]) -> str:
    """The first connected one in service with the fewest people aboard."""
    able = [shuttle for shuttle in shuttles if _is_free(shuttle.facts)]
    if not able:
        sys.exit("no shuttle is connected and free to drive; resume one in the console")
    return min(able, key=lambda shuttle: (shuttle.task.people_aboard, shuttle.vehicle_id)).vehicle_id


def _is_free(facts: VehicleFacts) -> bool:
    return facts.connected and facts.in_service and not facts.held


async def follow(campus: Campus, vehicle_id: str, visit_id: str) -> None:
    async for notification in campus.notifications():
        if notification.topic == "vehicles":
            for shuttle in notification.params["vehicles"]:
                if shuttle["vehicle_id"] == vehicle_id and shuttle["status"] is not None:
                    x_m, y_m, _ = shuttle["status"]["pose_map"]
                    print(f"\r{x_m:8.1f} {y_m:8.1f} m", end="", flush=True)
        elif notification.params["vehicle_id"] == vehicle_id:
            event = notification.params["body"]
            if event["event"] == "visit_changed" and event["visit_id"] == visit_id:
                print(f"\n{vehicle_id}: visit {event['state']}")
                if event["state"] in ("under_way", "done", "skipped"):
                    return


async def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("server", help="http://HOST:PORT")
    parser.add_argument("--stop", required=True, help="stop_id, see GET /api/v1/stops")
    parser.add_argument("--vehicle", help="vehicle_id; left out: a free one")
    arguments = parser.parse_args()
    token = os.environ.get("CAMPUSLOOP_TOKEN")
    if not token:
        sys.exit("set CAMPUSLOOP_TOKEN to a developer token made in the console")
    try:
        async with connect(arguments.server, token) as campus:
            await send_shuttle(campus, arguments.stop, arguments.vehicle)
    except (OSError, ConnectionLost, RequestRefused) as error:
        sys.exit(f"{arguments.server}: {error}")


if __name__ == "__main__":
    asyncio.run(main())
