"""`campusloop demo` in real time: server, simulator and agents as processes, and people who book.

What a visitor sees is the product itself: the only things simulated are bodies, sensors and people.
"""

import asyncio
import os
import secrets
import shutil
import signal
import ssl
import tempfile
import time
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any
from zoneinfo import ZoneInfo

import httpx
import numpy as np
import psutil
from rich.console import Console

from campusloop.certificate import local_addresses
from campusloop.commands.agent import prepare_folder
from campusloop.commands.serve import serve
from campusloop.commands.simulate import simulate
from campusloop.headless import RIDE_M_MIN, ride_pairs, timeline_line
from campusloop.operator_client import OperatorClient
from campusloop.passengers import Journey, Passengers, wishes
from campusloop.simulated_people import SimulatedPeople
from contract.roads.load import load_map
from simulator.live import scan_ring_path
from simulator.live_ports import BASE_PORT, control_port, ports_of
from vehicle_agent.config import Profile
from vehicle_agent.link.keys import load_or_make_key, public_key_text
from vehicle_agent.runtime.agent import AgentPlace, agent_jobs
from vehicle_agent.runtime.agent_files import VehicleFile
from vehicle_agent.runtime.supervisor import LOOK_EVERY_S, Job, Supervisor

READY_WITHIN_S = 60.0
POLL_EVERY_S = 0.2
CPU_EVERY_S = 60.0
RIDES_IN_ADVANCE = 10_000
SPACING_S = 100.0
OPERATOR = "operator"


class DemoError(Exception):
    """The demo cannot start; the message says what to do."""


@dataclass(frozen=True, slots=True)
class DemoOptions:
    """base_port: first of the simulator's loopback ports."""

    map_path: Path
    folder: Path
    vehicles: int
    host: str
    port: int
    tls_cert: Path | None
    tls_key: Path | None
    seed: int
    people_book: bool
    base_port: int = BASE_PORT


class LiveDemo:
    """Starts everything in the order in which it is needed, and stops it in the reverse order."""

    def __init__(self, options: DemoOptions, console: Console) -> None:
        self._options = options
        self._console = console
        self._password = secrets.token_urlsafe(6)
        self._mail = Path(tempfile.mkdtemp(prefix="campusloop-"))
        self._road_map = load_map(options.map_path)
        self._clock = ZoneInfo(self._road_map.timezone)
        self._supervisors: list[Supervisor] = []
        self._stopped = asyncio.Event()
        exposed = options.host not in ("127.0.0.1", "localhost")
        self._local = f"{'https' if exposed else 'http'}://127.0.0.1:{options.port}"
        self._certificate = options.tls_cert or (
            options.folder / "tls" / "certificate.pem" if exposed else None
        )

    async def run(self) -> None:
        """Until Ctrl-C or SIGTERM. Raises DemoError."""
        loop = asyncio.get_running_loop()
        for number in (signal.SIGINT, signal.SIGTERM):
            loop.add_signal_handler(number, self._stopped.set)
        shutil.rmtree(self._options.folder, ignore_errors=True)
        (self._options.folder / "logs").mkdir(parents=True)
        try:
            await self._live()
        finally:
            self._console.print("stopping")
            cores = self._cores_used()
            for supervisor in reversed(self._supervisors):
                await asyncio.to_thread(supervisor.stop)
            shutil.rmtree(self._mail, ignore_errors=True)
            self._console.print(f"stopped; the whole demo used {cores:.2f} cores on average")

    async def _live(self) -> None:
        self._began_s = time.monotonic()
        self._supervise([self._server_job()])
        watch = asyncio.create_task(self._watch())
        trusted = await self._server_certificate()
        async with httpx.AsyncClient(base_url=self._local, verify=trusted, timeout=30.0) as client:
            await self._until_ready(client)
            operator = OperatorClient(client)
            await operator.sign_in(OPERATOR, self._password)
            places = [await self._enrol(operator, number) for number in range(self._options.vehicles)]
            self._supervise([self._simulator_job()])
            self._supervise(
                [replace(job, log_file=self._log_file(job.name)) for job in agent_jobs(tuple(places))]
            )
            self._greet()
            releases = [operator.release(f"shuttle-{n + 1}") for n in range(self._options.vehicles)]
            work = asyncio.create_task(self._work(client, releases))
            await self._until_stopped([work, watch])

    async def _until_stopped(self, tasks: "list[asyncio.Task[None]]") -> None:
        """Until Ctrl-C, or until one of the tasks fails."""
        stopped = asyncio.create_task(self._stopped.wait())
        await asyncio.wait([stopped, *tasks], return_when=asyncio.FIRST_COMPLETED)
        stopped.cancel()
        for task in tasks:
            task.cancel()
        for ended in await asyncio.gather(*tasks, return_exceptions=True):
            if isinstance(ended, BaseException) and not isinstance(ended, asyncio.CancelledError):
                raise ended

    async def _work(self, client: httpx.AsyncClient, releases: list[Any]) -> None:
        await asyncio.gather(*releases)
        self._console.print("all shuttles are released and wait for rides")
        if self._options.people_book:
            await self._book(client)
        await asyncio.Event().wait()

    async def _book(self, client: httpx.AsyncClient) -> None:
        """People come for as long as the demo runs."""
        passengers: Passengers
        people = SimulatedPeople(self._road_map, control_port(self._options.base_port))

        def tell(journey: Journey) -> None:
            line = timeline_line(journey, datetime.now(UTC), self._clock)
            self._console.print(line, highlight=False, soft_wrap=True)

        passengers = Passengers(client, people, lambda: datetime.now(UTC), tell)
        pairs = ride_pairs(self._road_map, RIDE_M_MIN)
        rng = np.random.default_rng(self._options.seed)
        async with people.listening(passengers.tap), asyncio.TaskGroup() as lives:
            for wish in wishes(RIDES_IN_ADVANCE, pairs, SPACING_S, rng):
                journey = Journey(replace(wish, after_s=0.0))
                lives.create_task(passengers.live(journey))
                await asyncio.sleep(max(20.0, float(rng.exponential(SPACING_S))))

    # ------------------------------------------------------------ processes

    def _server_job(self) -> Job:
        options = self._options
        os.environ["CAMPUSLOOP_VAR_DIR"] = str(options.folder)
        os.environ["CAMPUSLOOP_OPERATOR_NAME"] = OPERATOR
        os.environ["CAMPUSLOOP_OPERATOR_PASSWORD"] = self._password
        arguments = (
            options.host,
            options.port,
            options.tls_cert,
            options.tls_key,
            False,
            False,
            options.map_path,
        )
        return Job("server", serve, arguments, log_file=self._log_file("server"))

    def _simulator_job(self) -> Job:
        options = self._options
        vehicles = ",".join(f"shuttle-{n + 1}" for n in range(options.vehicles))
        arguments = (
            options.map_path,
            vehicles,
            None,
            options.seed,
            options.base_port,
            self._scans,
            True,
            True,
        )
        return Job("simulator", simulate, arguments, log_file=self._log_file("simulator"))

    @property
    def _scans(self) -> Path:
        shared_memory = Path("/dev/shm")
        return (shared_memory if shared_memory.is_dir() else self._options.folder) / self._mail.name

    def _supervise(self, jobs: list[Job]) -> None:
        supervisor = Supervisor(jobs)
        supervisor.start()
        self._supervisors.append(supervisor)

    def _log_file(self, name: str) -> Path:
        return self._options.folder / "logs" / f"{name.replace(' ', '-')}.log"

    async def _watch(self) -> None:
        """Restart what ends; tell how much of the machine all of it takes."""
        next_s = time.monotonic() + CPU_EVERY_S
        while True:
            await asyncio.sleep(LOOK_EVERY_S)
            for supervisor in self._supervisors:
                supervisor.look()
            if time.monotonic() >= next_s:
                next_s += CPU_EVERY_S
                self._console.print(f"the whole demo uses {self._cores_used():.2f} cores", highlight=False)

    def _cores_used(self) -> float:
        """CPU time of this process and all its children since the start, over the time since then."""
        me = psutil.Process()
        used_s = sum(me.cpu_times()[:2])
        for child in me.children(recursive=True):
            try:
                used_s += sum(child.cpu_times()[:2])
            except psutil.NoSuchProcess:
                continue
        return float(used_s / (time.monotonic() - self._began_s))

    # ------------------------------------------------------------ vehicles

    async def _server_certificate(self) -> ssl.SSLContext | bool:
        """What to verify the server's TLS with; a certificate of its own making is there after its start."""
        if self._certificate is None:
            return True
        for _ in range(round(READY_WITHIN_S / POLL_EVERY_S)):
            if self._certificate.exists():
                break
            await asyncio.sleep(POLL_EVERY_S)
        else:
            raise DemoError(f"the server made no certificate at {self._certificate}; see its log")
        return ssl.create_default_context(cafile=self._certificate)

    async def _until_ready(self, client: httpx.AsyncClient) -> None:
        for _ in range(round(READY_WITHIN_S / POLL_EVERY_S)):
            if await _is_ready(client):
                return
            await asyncio.sleep(POLL_EVERY_S)
        log = self._log_file("server").read_text()[-2000:]
        raise DemoError(f"the server did not come up within {READY_WITHIN_S:.0f} s; it said:\n{log}")

    async def _enrol(self, operator: OperatorClient, number: int) -> AgentPlace:
        vehicle_id = f"shuttle-{number + 1}"
        folder = self._options.folder / "vehicles" / vehicle_id
        key = load_or_make_key(folder / "key.pem")
        await operator.enrol(vehicle_id, Profile().body, public_key_text(key))
        ports = ports_of(number, self._options.base_port)
        vehicle = VehicleFile(
            vehicle_id=vehicle_id,
            server_url=self._local,
            can_channel=ports.can_channel,
            values_port=ports.values_port,
            scans_port=ports.scans_port,
            words_port=ports.words_port,
            scan_ring=str(scan_ring_path(self._scans, vehicle_id)),
            server_certificate=str(self._certificate) if self._certificate else "",
        )
        prepare_folder(folder, vehicle, self._options.map_path, None)
        return AgentPlace(folder.resolve(), self._mail / str(number))

    def _greet(self) -> None:
        print_line = self._console.print
        for origin in self._origins():
            print_line(f"passengers  {origin}/", highlight=False)
            print_line(f"operators   {origin}/console", highlight=False)
        print_line(f"operator's name: {OPERATOR}   password: {self._password}", highlight=False)
        print_line(f"runs and logs: {self._options.folder}   Ctrl-C stops everything", highlight=False)

    def _origins(self) -> list[str]:
        if self._certificate is None:
            return [self._local]
        return [f"https://{name}:{self._options.port}" for name in local_addresses(self._options.host)]


async def _is_ready(client: httpx.AsyncClient) -> bool:
    try:
        return (await client.get("/api/v1/ready")).is_success
    except httpx.TransportError:
        # Not listening yet.
        return False
