"""`campusloop demo` in real time: a live campus, simulated passengers, and the progress on the terminal.

Server, agents and pages are the real ones. Only vehicle bodies, sensors and people are simulated.
"""

import asyncio
import signal
import ssl
import sys
from dataclasses import replace
from zoneinfo import ZoneInfo

import httpx
import numpy as np
from rich.console import Console

from campusloop.clients.demo_cameras import DemoCameras, camera_token
from campusloop.clients.demo_operator import DemoOperator
from campusloop.clients.operator_client import OperatorError
from campusloop.clients.passengers import Journey, Passengers, RideDemand
from campusloop.clients.ride_demand import RIDE_M_MAX, RIDE_M_MIN, nearest_pairs, random_rides, stop_pairs
from campusloop.clients.simulated_people import SimulatedPeople
from campusloop.live.campus import OPERATOR, LiveCampus, LiveOptions
from campusloop.live.certificate import local_addresses
from campusloop.live.next_commands import next_commands
from campusloop.live.progress import DemoProgress
from contract.roads.model import RoadMap
from simulator.live.ports import control_port, ports_of

FOLLOW_EVERY_S = 2.0
# More than are booked between two readings; older ones under way are read one by one.
NEWEST_RIDES = 50
PEOPLE = 10_000
SPACING_S = 100.0
SPACING_S_MIN = 20.0
# The first rides may be shorter than the others.
FIRST_M_MIN = 250.0


class LiveDemo:
    """Starts the campus, prints its addresses, lets passengers book, and stops everything on Ctrl-C."""

    def __init__(self, options: LiveOptions, console: Console, *, people_book: bool) -> None:
        self._campus = LiveCampus(options)
        self._people_book = people_book
        self._released = asyncio.Event()
        self._progress = DemoProgress(console, self._campus.now, ZoneInfo(self._campus.road_map.timezone))

    async def run(self) -> None:
        """Run until Ctrl-C or SIGTERM. Raises CampusStartError, ForeignFolder."""
        stopped = asyncio.Event()
        for number in (signal.SIGINT, signal.SIGTERM):
            asyncio.get_running_loop().add_signal_handler(number, stopped.set)
        try:
            self._say("starting server, simulator and shuttles")
            await self._campus.start()
            self._print_addresses()
            with self._progress:
                await self._until(stopped)
            self._count()
        finally:
            self._say("stopping")
            await self._campus.stop()
        folder, newest = self._campus.options.folder, self._progress.newest_code()
        for line in (*self._progress.summary(), *next_commands(folder, newest, sys.argv[0])):
            self._say(line)

    async def _until(self, stopped: asyncio.Event) -> None:
        """Wait for the stop event, or until one of the tasks fails."""
        tasks = [
            asyncio.create_task(coroutine)
            for coroutine in (
                self._campus.watch(),
                self._serve_people(),
                self._follow(),
                self._operate(),
                self._watch_crossings(),
            )
        ]
        waiting = asyncio.create_task(stopped.wait())
        await asyncio.wait([waiting, *tasks], return_when=asyncio.FIRST_COMPLETED)
        waiting.cancel()
        for task in tasks:
            task.cancel()
        for ended in await asyncio.gather(*tasks, return_exceptions=True):
            if isinstance(ended, BaseException) and not isinstance(ended, asyncio.CancelledError):
                raise ended

    async def _serve_people(self) -> None:
        await self._campus.release_all()
        self._released.set()
        if self._people_book:
            await self._book()
        await asyncio.Event().wait()

    async def _book(self) -> None:
        """New passengers come for as long as the demo runs."""
        options = self._campus.options
        people = SimulatedPeople(self._campus.road_map, control_port(options.base_port))
        passengers = Passengers(self._campus.client, people, self._campus.now)
        rng = np.random.default_rng(options.seed)
        async with people.listening(passengers.tap), asyncio.TaskGroup() as journeys:
            for ride in first_rides(self._campus.road_map, options.vehicles, rng):
                journeys.create_task(passengers.run_journey(Journey(replace(ride, after_s=0.0))))
                await asyncio.sleep(max(SPACING_S_MIN, float(rng.exponential(SPACING_S))))

    async def _operate(self) -> None:
        # A starting shuttle has no scan yet. It stops for that reason, which is not an incident to release.
        await self._released.wait()
        await DemoOperator(self._campus.operator, self._say, self._progress.released).run()

    async def _watch_crossings(self) -> None:
        """A camera at each crossing of the map, with a token of its own."""
        campus = self._campus
        if not any(area.kind == "crossing" for area in campus.road_map.observation_areas):
            await asyncio.Event().wait()
        token = await camera_token(campus.operator, self._say)
        tls = campus.trusted if isinstance(campus.trusted, ssl.SSLContext) else None
        port = control_port(campus.options.base_port)
        await DemoCameras(campus.origin, token, tls, port, self._say).run()

    async def _follow(self) -> None:
        """Show the shuttles and all rides on the terminal: who booked them does not matter."""
        while True:
            try:
                self._progress.vehicles(await self._campus.operator.vehicles())
                await self._follow_rides()
            except (httpx.TransportError, OperatorError) as error:
                self._say(f"the server does not answer where shuttles and rides are: {error}")
            self._count()
            await asyncio.sleep(FOLLOW_EVERY_S)

    async def _follow_rides(self) -> None:
        operator = self._campus.operator
        newest = await operator.newest_rides(NEWEST_RIDES)
        self._progress.rides(newest)
        older = self._progress.under_way() - {ride["ride_id"] for ride in newest}
        self._progress.rides([await operator.ride(ride_id) for ride_id in sorted(older)])

    def _count(self) -> None:
        self._progress.counts.lag_s = self._campus.lag_s
        self._progress.counts.cores = self._campus.cores_used()

    def _print_addresses(self) -> None:
        options = self._campus.options
        names = local_addresses(options.host) if self._campus.certificate else []
        hosts = [f"[{name}]" if ":" in name else name for name in names]
        for origin in [f"https://{host}:{options.port}" for host in hosts] or [self._campus.origin]:
            self._say(f"passengers  {origin}/")
            self._say(f"operators   {origin}/console")
        if options.screen_pages is not None:
            port = ports_of(0, options.base_port).screen_port
            self._say(f"on board    http://127.0.0.1:{port}/onboard/{self._campus.vehicle_ids[0]}")
        self._say(f"operator's name: {OPERATOR}   password: {self._campus.password}")
        self._say(f"runs and logs: {options.folder}   Ctrl-C stops everything")

    def _say(self, text: str) -> None:
        self._progress.say(text)


def first_rides(road_map: RoadMap, vehicles: int, rng: np.random.Generator) -> list[RideDemand]:
    """Random rides. The first ones are near the waiting shuttles, so that whole rides soon happen."""
    short = stop_pairs(road_map, FIRST_M_MIN, RIDE_M_MAX)
    near = nearest_pairs(road_map, short, road_map.resting_places[:vehicles])
    rides = random_rides(PEOPLE, stop_pairs(road_map, RIDE_M_MIN, RIDE_M_MAX), SPACING_S, rng)
    first = [replace(ride, from_stop=a, to_stop=b) for ride, (a, b) in zip(rides, near, strict=False)]
    return first + rides[len(first) :]
