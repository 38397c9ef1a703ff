"""A campus in real time on one machine: server, simulator and agents as processes, kept running."""

import asyncio
import os
import secrets
import ssl
import time
from dataclasses import dataclass
from datetime import UTC, datetime
from functools import partial
from pathlib import Path

import httpx
import psutil

from campusloop.clients.operator_client import OperatorClient
from campusloop.live.jobs import serve
from campusloop.live.run_folder import empty_folder
from campusloop.live.shuttles import ShuttleOptions, SimulatedShuttles
from simulator.live.ports import BASE_PORT
from simulator.sensors.scene_lidars import SceneOptions
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
    plant_seed: of the shuttles' dynamics; None: nominal ones
    scene: hills, kerbs, trees and parked vehicles, and lidars that see them; None: none
    point_map: the folder of the map that the shuttles compare their scans with; None: GNSS/INS alone
    by_scans: the shuttles compare their scans with the map that the server has in force, or with point_map
    screen_pages: built web pages for the first shuttle's onboard screen; None: no shuttle serves one
    cameras: each shuttle records four cameras, which see the scene
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
    plant_seed: int | None = None
    scene: SceneOptions | None = None
    point_map: Path | None = None
    screen_pages: Path | None = None
    by_scans: bool = False
    cameras: bool = False


class LiveCampus:
    """Call `start`; then use `client` and `operator` as from outside while `watch` runs; then `stop`."""

    def __init__(self, options: LiveOptions) -> None:
        """Raises MapError, ProfileError."""
        self.options = options
        self.password = secrets.token_urlsafe(6)
        self._began_s = time.monotonic()
        exposed = options.host not in ("127.0.0.1", "localhost")
        self_signed = options.folder / "tls" / "certificate.pem" if exposed else None
        self.certificate = options.tls_cert or self_signed
        self.origin = f"{'https' if exposed else 'http'}://127.0.0.1:{options.port}"
        self._shuttles = SimulatedShuttles(
            ShuttleOptions(
                map_path=options.map_path,
                folder=options.folder,
                vehicle_ids=tuple(self.vehicle_ids),
                server_url=self.origin,
                server_certificate=self.certificate,
                seed=options.seed,
                base_port=options.base_port,
                pedestrians=options.pedestrians,
                profile_path=options.profile_path,
                paced=options.paced,
                plant_seed=options.plant_seed,
                scene=options.scene,
                point_map=options.point_map,
                screen_pages=options.screen_pages,
                by_scans=options.by_scans,
                cameras=options.cameras,
            )
        )
        self.road_map = self._shuttles.road_map
        self._server = Supervisor([self._server_job()])
        # What the server's TLS is verified with, from `start` on.
        self.trusted: ssl.SSLContext | bool = True
        self.client = httpx.AsyncClient(base_url=self.origin)
        self.operator = OperatorClient(self.client)

    @property
    def vehicle_ids(self) -> list[str]:
        return [f"shuttle-{number + 1}" for number in range(self.options.vehicles)]

    @property
    def pids(self) -> dict[str, int]:
        """Process ids by name: server, simulator, link, worker, "gate shuttle-1", "tick shuttle-1"."""
        return self._server.pids | self._shuttles.pids

    def now(self) -> datetime:
        """By the clock of this campus's processes."""
        clock = self._shuttles.clock
        return datetime.now(UTC) if clock is None else clock.utc()

    @property
    def lag_s(self) -> float:
        """How far the campus's clock is behind the wall clock, because the machine did not keep up."""
        clock = self._shuttles.clock
        return 0.0 if clock is None else clock.lag_ns() * 1e-9

    async def start(self) -> None:
        """Start all processes and enrol the vehicles; the vehicles are still held.

        Raises CampusStartError, ForeignFolder.
        """
        (empty_folder(self.options.folder) / "logs").mkdir()
        self._server.start()
        # Started while the server starts, which takes longer. Stopped after the agents, which need its clock.
        self._shuttles.start_simulator()
        self.trusted = trusted = await self._trusted()
        self.client = httpx.AsyncClient(base_url=self.origin, verify=trusted, timeout=30.0)
        self.operator = OperatorClient(self.client)
        await self._until_ready()
        await self.operator.sign_in(OPERATOR, self.password)
        await self._shuttles.start_agents(self.operator)

    async def release_all(self) -> None:
        """Resume every vehicle as soon as it is connected and placed."""
        await self._shuttles.release_all(self.operator)

    async def watch(self) -> None:
        """Restart processes that end, until cancelled."""
        while True:
            await asyncio.sleep(CHECK_EVERY_S)
            self._server.restart_ended()
            self._shuttles.restart_ended()

    async def stop(self) -> None:
        """Stop the agents, then the simulator, then the server. No process is left running."""
        await self._shuttles.stop()
        await asyncio.to_thread(self._server.stop)
        await self.client.aclose()

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
        target = partial(serve, clocks=self._shuttles.clocks)
        return Job("server", target, arguments, log_file=self.log_file("server"))

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
            if self._server.has_ended("server"):
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
