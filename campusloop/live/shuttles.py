"""Simulated shuttles in real time: the simulator and the agents' processes, for any server."""

import asyncio
import os
import shutil
import tempfile
from dataclasses import dataclass, replace
from pathlib import Path

from campusloop.clients.operator_client import OperatorClient
from campusloop.live.jobs import simulate, take_pictures
from campusloop.live.paced_clock import PacedClock, PacedClocks
from campusloop.live.simulated_cameras import cameras_file
from campusloop.telemetry.otlp_spans import span_source
from contract.roads.load import load_map
from simulator.live.live import scan_ring_path
from simulator.live.ports import BASE_PORT, ports_of
from simulator.sensors.scene_lidars import SceneOptions
from vehicle_agent.config import Profile, load_profile
from vehicle_agent.link.keys import load_or_create_key, public_key_text
from vehicle_agent.runtime.processes.agent import AgentPlace
from vehicle_agent.runtime.processes.agent_files import AgentFolder, VehicleFile
from vehicle_agent.runtime.processes.agent_jobs import agent_jobs
from vehicle_agent.runtime.processes.clock import MONOTONIC
from vehicle_agent.runtime.processes.supervisor import Job, Supervisor
from vehicle_agent.runtime.screen.screen_settings import ScreenSettings


@dataclass(frozen=True, slots=True)
class ShuttleOptions:
    """vehicle_ids: the first one waits at the map's first resting place, and so on.

    folder        of keys, runs and logs; kept, so that shuttles are the same ones at the next start
    server_url    how the agents reach the server
    server_certificate   what they trust besides the system's certificates
    base_port     first of the simulator's loopback ports
    profile_path  of every shuttle; None: the campus shuttle
    paced         all processes share a clock that waits for a slow machine (`paced_clock`)
    plant_seed    of the shuttles' dynamics; None: nominal ones
    scene         hills, kerbs, trees and parked vehicles, and lidars that see them; None: none
    point_map     folder of the map that the shuttles compare their scans with; None: GNSS/INS alone
    by_scans      compare scans with the map that the server has in force, or with point_map
    screen_pages  built web pages: the first shuttle serves its onboard screen; None: no shuttle does
    cameras       each shuttle records four cameras, which see the scene
    """

    map_path: Path
    folder: Path
    vehicle_ids: tuple[str, ...]
    server_url: str
    server_certificate: Path | None = None
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


class SimulatedShuttles:
    """Call `start_simulator`; `start_agents` when the server is ready; `restart_ended` repeatedly; `stop`."""

    def __init__(self, options: ShuttleOptions) -> None:
        """Raises MapError, ProfileError, TracingUnavailable."""
        self.options = options
        self.road_map = load_map(options.map_path)
        self._profile = Profile() if options.profile_path is None else load_profile(options.profile_path)
        self._mail = Path(tempfile.mkdtemp(prefix="campusloop-"))
        self._supervisors: list[Supervisor] = []
        self._spans = span_source()
        self.clocks = self._created_clocks() if options.paced else None
        self.clock: PacedClock | None = None if self.clocks is None else self.clocks.open("campus")

    @property
    def pids(self) -> dict[str, int]:
        """Process ids by name: simulator, link, worker, "gate shuttle-1", "tick shuttle-1"."""
        return {name: pid for supervisor in self._supervisors for name, pid in supervisor.pids.items()}

    def start_simulator(self) -> None:
        """It may start before the server, which takes longer."""
        (self.options.folder / "logs").mkdir(parents=True, exist_ok=True)
        self._supervise([self._simulator_job(), *self._camera_jobs()])

    async def start_agents(self, operator: OperatorClient) -> None:
        """Enrol every shuttle and start its processes; the shuttles are still held.

        operator: signed in. Raises OperatorError, httpx.TransportError.
        """
        places = tuple(self._place(number, name) for number, name in enumerate(self.options.vehicle_ids))
        for name, place in zip(self.options.vehicle_ids, places, strict=True):
            key = load_or_create_key(place.folder / "key.pem")
            await operator.enrol(name, self._profile.body, public_key_text(key))
        self._supervise([replace(job, log_file=self.log_file(job.name)) for job in agent_jobs(places)])

    async def release_all(self, operator: OperatorClient) -> None:
        """Resume every shuttle as soon as it is connected and placed."""
        await asyncio.gather(*(operator.release(name) for name in self.options.vehicle_ids))

    def restart_ended(self) -> None:
        for supervisor in self._supervisors:
            supervisor.restart_ended()

    async def stop(self) -> None:
        """Stop the agents, then the simulator, whose clock they need. No process is left running."""
        for supervisor in reversed(self._supervisors):
            await asyncio.to_thread(supervisor.stop)
        shutil.rmtree(self._mail, ignore_errors=True)
        shutil.rmtree(self._scans, ignore_errors=True)

    def log_file(self, name: str) -> Path:
        return self.options.folder / "logs" / f"{name.replace(' ', '-')}.log"

    def _simulator_job(self) -> Job:
        options = self.options
        arguments = (
            options.map_path,
            options.vehicle_ids,
            options.profile_path,
            options.seed,
            options.base_port,
            self._scans,
            options.pedestrians,
            True,
            self.clocks,
            options.plant_seed,
            options.scene,
        )
        return Job("simulator", simulate, arguments, log_file=self.log_file("simulator"))

    def _camera_jobs(self) -> list[Job]:
        options = self.options
        if not options.cameras or options.scene is None:
            return []
        arguments = (
            options.map_path, options.vehicle_ids, options.profile_path, self._scans, options.scene
        )  # fmt: skip
        return [Job("cameras", take_pictures, arguments, log_file=self.log_file("cameras"))]

    @property
    def _scans(self) -> Path:
        """For the scans and the clock, which exists before the folder does."""
        shared_memory = Path("/dev/shm")
        writable = shared_memory.is_dir() and os.access(shared_memory, os.W_OK)
        return shared_memory / self._mail.name if writable else self._mail / "scans"

    def _created_clocks(self) -> PacedClocks:
        clocks = PacedClocks(self._scans / "clock")
        clocks.create()
        return clocks

    def _supervise(self, jobs: list[Job]) -> None:
        supervisor = Supervisor(jobs)
        self._supervisors.append(supervisor)
        supervisor.start()

    def _place(self, number: int, vehicle_id: str) -> AgentPlace:
        options = self.options
        folder = options.folder / "vehicles" / vehicle_id
        load_or_create_key(folder / "key.pem")
        ports = ports_of(number, options.base_port)
        vehicle = VehicleFile(
            vehicle_id=vehicle_id,
            server_url=options.server_url,
            can_channel=ports.can_channel,
            values_port=ports.values_port,
            scans_port=ports.scans_port,
            hmi_port=ports.hmi_port,
            scan_ring=str(scan_ring_path(self._scans, vehicle_id)),
            server_certificate=str(options.server_certificate) if options.server_certificate else "",
            by_scans=options.by_scans,
        )
        files = AgentFolder(folder)
        files.prepare(vehicle, options.map_path, options.profile_path)
        if options.point_map is not None:
            files.install_point_map(options.point_map)
        elif not options.by_scans:
            files.remove_point_map()
        if options.cameras:
            files.save_cameras(cameras_file())
        else:
            files.remove_cameras(cameras_file())
        if number == 0 and options.screen_pages is not None:
            listen = f"127.0.0.1:{ports.screen_port}"
            files.save_screen(ScreenSettings(listen=listen, pages=str(options.screen_pages.resolve())))
        clocks = self.clocks or MONOTONIC
        return AgentPlace(folder.resolve(), self._mail / str(number), clocks, self._spans)
