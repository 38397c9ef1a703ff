"""A campus in real time on one machine: server, simulator and agents as processes, kept running."""

import asyncio
import os
import secrets
import shutil
import ssl
import tempfile
import time
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from functools import partial
from pathlib import Path

import httpx
import psutil

from campusloop.clients.operator_client import OperatorClient
from campusloop.live.jobs import serve, simulate
from campusloop.live.paced_clock import PacedClock, PacedClocks
from campusloop.live.run_folder import empty_folder
from contract.roads.load import load_map
from simulator.live.live import scan_ring_path
from simulator.live.ports import BASE_PORT, ports_of
from vehicle_agent.config import Profile, load_profile
from vehicle_agent.link.keys import load_or_create_key, public_key_text
from vehicle_agent.runtime.processes.agent import AgentPlace, agent_jobs
from vehicle_agent.runtime.processes.agent_files import AgentFolder, VehicleFile
from vehicle_agent.runtime.processes.clock import MONOTONIC
from vehicle_agent.runtime.processes.supervisor import CHECK_EVERY_S, Job, Supervisor

READY_WITHIN_S = 60.0
POLL_EVERY_S = 0.2
OPERATOR = "operator"


class CampusStartError(Exception):
    """The campus cannot start; the message says what to do."""


@dataclass(frozen=True, slots=True)
class LiveOptions:
    """folder is deleted and created again. base_port: first of the simulator's loopback ports.

    profile_path: of every shuttle; None: the campus shuttle
    paced: all processes share a clock that runs slower where the machine does not keep up (`paced_clock`);
    otherwise they have the computer's clock
    """

    map_path: Path
    folder: Path
    vehicles: int
    host: str = "127.0.0.1"
    port: int = 8080
    tls_cert: Path | None = None
    tls_key: Path | None = None
    seed: int = 1
    base_port: int = BASE_PORT
    pedestrians: bool = True
    profile_path: Path | None = None
    paced: bool = False


class LiveCampus:
    """Call `start`; then use `client` and `operator` as from outside while `watch` runs; then `stop`."""

    def __init__(self, options: LiveOptions) -> None:
        """Raises MapError, ProfileError."""
        self.options = options
        self.password = secrets.token_urlsafe(6)
        self.road_map = load_map(options.map_path)
        self._profile = Profile() if options.profile_path is None else load_profile(options.profile_path)
        self._mail = Path(tempfile.mkdtemp(prefix="campusloop-"))
        self._supervisors: list[Supervisor] = []
        self._clocks = self._created_clocks() if options.paced else None
        self._clock: PacedClock | None = None if self._clocks is None else self._clocks.open("campus")
        self._began_s = time.monotonic()
        exposed = options.host not in ("127.0.0.1", "localhost")
        self_signed = options.folder / "tls" / "certificate.pem" if exposed else None
        self.certificate = options.tls_cert or self_signed
        self.origin = f"{'https' if exposed else 'http'}://127.0.0.1:{options.port}"
        self.client = httpx.AsyncClient(base_url=self.origin)
        self.operator = OperatorClient(self.client)

    @property
    def vehicle_ids(self) -> list[str]:
        return [f"shuttle-{number + 1}" for number in range(self.options.vehicles)]

    @property
    def pids(self) -> dict[str, int]:
        """Process ids by name: server, simulator, link, worker, "gate shuttle-1", "tick shuttle-1"."""
        return {name: pid for supervisor in self._supervisors for name, pid in supervisor.pids.items()}

    def now(self) -> datetime:
        """By the clock of this campus's processes."""
        return datetime.now(UTC) if self._clock is None else self._clock.utc()

    @property
    def lag_s(self) -> float:
        """How far the campus's clock is behind the wall clock, because the machine did not keep up."""
        return 0.0 if self._clock is None else self._clock.lag_ns() * 1e-9

    async def start(self) -> None:
        """Start all processes and enrol the vehicles; the vehicles are still held.

        Raises CampusStartError, ForeignFolder.
        """
        (empty_folder(self.options.folder) / "logs").mkdir()
        self._supervise([self._server_job()])
        places = tuple(self._place(number, name) for number, name in enumerate(self.vehicle_ids))
        # Started while the server starts, which takes longer. Stopped after the agents, which need its clock.
        self._supervise([self._simulator_job()])
        trusted = await self._trusted()
        self.client = httpx.AsyncClient(base_url=self.origin, verify=trusted, timeout=30.0)
        self.operator = OperatorClient(self.client)
        await self._until_ready()
        await self.operator.sign_in(OPERATOR, self.password)
        for name, place in zip(self.vehicle_ids, places, strict=True):
            key = load_or_create_key(place.folder / "key.pem")
            await self.operator.enrol(name, self._profile.body, public_key_text(key))
        # In the order of `agent_jobs`: a tick that starts before its link loses the beginning of its run log.
        jobs = agent_jobs(places)
        self._supervise([replace(job, log_file=self.log_file(job.name)) for job in jobs])

    async def release_all(self) -> None:
        """Resume every vehicle as soon as it is connected and placed."""
        await asyncio.gather(*(self.operator.release(name) for name in self.vehicle_ids))

    async def watch(self) -> None:
        """Restart processes that end, until cancelled."""
        while True:
            await asyncio.sleep(CHECK_EVERY_S)
            for supervisor in self._supervisors:
                supervisor.restart_ended()

    async def stop(self) -> None:
        """Stop the agents, then the simulator, then the server. No process is left running."""
        for supervisor in reversed(self._supervisors):
            await asyncio.to_thread(supervisor.stop)
        await self.client.aclose()
        shutil.rmtree(self._mail, ignore_errors=True)
        shutil.rmtree(self._scans, ignore_errors=True)

    def log_file(self, name: str) -> Path:
        return self.options.folder / "logs" / f"{name.replace(' ', '-')}.log"

    def cores_used(self) -> float:
        """CPU time of this process and all its children since the start, over the time since then."""
        me = psutil.Process()
        used_s = sum(me.cpu_times()[:2])
        for child in me.children(recursive=True):
            try:
                used_s += sum(child.cpu_times()[:2])
            except psutil.NoSuchProcess:
                continue
        return float(used_s / (time.monotonic() - self._began_s))

    # ------------------------------------------------------------ processes

    def _server_job(self) -> Job:
        options = self.options
        os.environ["CAMPUSLOOP_VAR_DIR"] = str(options.folder)
        os.environ["CAMPUSLOOP_OPERATOR_NAME"] = OPERATOR
        os.environ["CAMPUSLOOP_OPERATOR_PASSWORD"] = self.password
        arguments = (
            options.host,
            options.port,
            options.tls_cert,
            options.tls_key,
            options.map_path,
        )
        target = partial(serve, clocks=self._clocks)
        return Job("server", target, arguments, log_file=self.log_file("server"))

    def _simulator_job(self) -> Job:
        options = self.options
        arguments = (
            options.map_path,
            tuple(self.vehicle_ids),
            options.profile_path,
            options.seed,
            options.base_port,
            self._scans,
            options.pedestrians,
            True,
            self._clocks,
        )
        return Job("simulator", simulate, arguments, log_file=self.log_file("simulator"))

    @property
    def _scans(self) -> Path:
        """For the scans and the clock, which exists before `start` empties the options' folder."""
        shared_memory = Path("/dev/shm")
        return shared_memory / self._mail.name if shared_memory.is_dir() else self._mail / "scans"

    def _created_clocks(self) -> PacedClocks:
        clocks = PacedClocks(self._scans / "clock")
        clocks.create()
        return clocks

    def _supervise(self, jobs: list[Job]) -> None:
        supervisor = Supervisor(jobs)
        self._supervisors.append(supervisor)
        supervisor.start()

    async def _trusted(self) -> ssl.SSLContext | bool:
        """What to verify the server's TLS with. A self-signed certificate exists after the server's start."""
        if self.certificate is None:
            return True
        for _ in range(round(READY_WITHIN_S / POLL_EVERY_S)):
            if self.certificate.exists():
                return ssl.create_default_context(cafile=self.certificate)
            await asyncio.sleep(POLL_EVERY_S)
        raise CampusStartError(
            f"the server wrote no certificate to {self.certificate}; its log:\n{self._server_log()}"
        )

    async def _until_ready(self) -> None:
        for _ in range(round(READY_WITHIN_S / POLL_EVERY_S)):
            if self._supervisors[0].has_ended("server"):
                raise CampusStartError(f"the server did not start; its log:\n{self._server_log()}")
            if await self._is_ready():
                return
            await asyncio.sleep(POLL_EVERY_S)
        raise CampusStartError(
            f"the server was not ready after {READY_WITHIN_S:.0f} s; its log:\n{self._server_log()}"
        )

    async def _is_ready(self) -> bool:
        try:
            return (await self.client.get("/api/v1/ready")).is_success
        except httpx.TransportError:
            # Not listening yet.
            return False

    def _server_log(self) -> str:
        log = self.log_file("server")
        return log.read_text()[-2000:] if log.exists() else "(nothing)"

    def _place(self, number: int, vehicle_id: str) -> AgentPlace:
        folder = self.options.folder / "vehicles" / vehicle_id
        load_or_create_key(folder / "key.pem")
        ports = ports_of(number, self.options.base_port)
        vehicle = VehicleFile(
            vehicle_id=vehicle_id,
            server_url=self.origin,
            can_channel=ports.can_channel,
            values_port=ports.values_port,
            scans_port=ports.scans_port,
            hmi_port=ports.hmi_port,
            scan_ring=str(scan_ring_path(self._scans, vehicle_id)),
            server_certificate=str(self.certificate) if self.certificate else "",
        )
        AgentFolder(folder).prepare(vehicle, self.options.map_path, self.options.profile_path)
        return AgentPlace(folder.resolve(), self._mail / str(number), self._clocks or MONOTONIC)
