"""A world in real time, in one process; each vehicle has a CAN bus and a device feed."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from simulator.ecus.command_watch import COMMAND_TIMEOUT_NS
from simulator.fleet import STEP_NS
from simulator.infrastructure import CrossingCamera
from simulator.live.bus import LiveBus
from simulator.live.clock import WALL, Clock
from simulator.live.control_server import ControlServer, RemotePhones
from simulator.live.moment_file import Moment, MomentFile, moment_path
from simulator.live.ports import VehiclePorts, control_port, ports_of
from simulator.world import SimWorld
from vehicle_agent.can.pacmod.commands import FRAME_GAP_NS
from vehicle_agent.device_feed import (
    Array32,
    DatagramPort,
    DeviceOutputs,
    DeviceValue,
    DeviceValues,
    ScanRing,
    people_ring_path,
    planar_ring_path,
)
from vehicle_agent.picture_ring import PEOPLE_CAMERA, PictureRing, picture_ring_path
from vehicle_agent.picture_windows import PictureWindows, picture_windows_path
from vehicle_agent.signals.pictures import Picture

LATE_MAX_NS = 5 * STEP_NS
SCORES_EVERY_STEPS = 50
# Of the file in which other processes see what moves: cameras look no more often.
MOMENT_EVERY_STEPS = 5
# Arrival stamps jitter by the operating system's scheduling; only much smaller gaps count as too close.
LIVE_FRAME_GAP_NS = FRAME_GAP_NS // 4
# A real module has a processor of its own. Here it shares one, and a pause of a tenth of a second may be the
# machine's and not the vehicle computer's.
LIVE_COMMAND_TIMEOUT_NS = 2 * COMMAND_TIMEOUT_NS


class VehicleWiring:
    """The simulation's ends of one vehicle's bus and device feed."""

    def __init__(self, vehicle_id: str, ports: VehiclePorts, folder: Path, clock: Clock) -> None:
        self.vehicle_id, self.ports = vehicle_id, ports
        self.bus = LiveBus(ports.can_channel, clock.now_ns)
        self.outputs = DatagramPort(ports.hmi_port)
        path = scan_ring_path(folder, vehicle_id)
        self.ring = ScanRing(path, create=True)
        # No datagram tells of these: the workers of localization and perception look into the rings.
        self._planar, self._people = _PlanarRing(planar_ring_path(path)), _PlanarRing(people_ring_path(path))
        self._pictures = _WantedPictures(path)
        self._scans = 0

    def exchange(self, world: SimWorld, now_ns: int) -> None:
        """Send the devices' values at now_ns, and execute the vehicle's device outputs."""
        self.bus.send(world.frames_to_vehicle(self.vehicle_id))
        items = [*world.sensor_items(self.vehicle_id, now_ns), *world.tracked(self.vehicle_id, now_ns)]
        values = tuple(item for item in items if isinstance(item, DeviceValue))
        self.outputs.send(self.ports.values_port, DeviceValues(values))
        scan = world.scan(self.vehicle_id, now_ns)
        if scan is not None:
            ready = self.ring.write(self._scans, now_ns, *scan)
            self.outputs.send(self.ports.scans_port, ready)
            self._scans += 1
        self._planar.write(now_ns, world.planar_scan(self.vehicle_id, now_ns))
        self._people.write(now_ns, world.people_scan(self.vehicle_id, now_ns))
        self._pictures.write(world.picture(self.vehicle_id, now_ns, self._pictures.windows))
        for datagram in self.outputs.take():
            if isinstance(datagram, DeviceOutputs):
                world.show(self.vehicle_id, datagram.hmi, now_ns)

    def close(self) -> None:
        self.bus.close()
        self.outputs.close()


class _PlanarRing:
    """A planar scanner's ring; a vehicle without the scanner has no file."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._ring: ScanRing | None = None
        self._scans = 0

    def write(self, now_ns: int, scan: tuple[Array32, Array32] | None) -> None:
        if scan is None:
            return
        self._ring = self._ring or ScanRing(self._path, create=True)
        self._ring.write(self._scans, now_ns, *scan)
        self._scans += 1


class _WantedPictures:
    """The pictures of the camera for people: of each, the parts at which the vehicle's worker will look."""

    def __init__(self, scan_ring: Path) -> None:
        self._path = picture_ring_path(scan_ring, PEOPLE_CAMERA)
        self._windows_path = picture_windows_path(scan_ring, PEOPLE_CAMERA)
        self._ring: PictureRing | None = None
        self._windows: PictureWindows | None = None

    def windows(self) -> NDArray[np.int64] | None:
        """(k, 4) as `PictureWindows.asked`; None before the worker has started, too."""
        if self._windows is None:
            try:
                self._windows = PictureWindows(self._windows_path, create=False)
            except OSError:
                # The worker makes the file when it starts.
                return None
        return self._windows.asked()

    def write(self, picture: Picture | None) -> None:
        if picture is None:
            return
        self._ring = self._ring or PictureRing(self._path, create=True)
        self._ring.write(picture.stamp_ns, picture.pixels)


class LiveSimulation:
    """Steps the world every 20 ms without drift.

    late_steps: steps that began more than one period late. lost_ns: total time for which the world stood
    still because the process had no processor for longer than LATE_MAX_NS.
    """

    def __init__(
        self,
        world: SimWorld,
        phones: RemotePhones,
        folder: Path,
        base_port: int,
        clock: Clock = WALL,
        frame_gap_ns: int = LIVE_FRAME_GAP_NS,
        cameras: tuple[CrossingCamera, ...] = (),
    ) -> None:
        """folder: of the scan rings. frame_gap_ns: frames closer than that are lost, as on a real bus.
        cameras: over crossings; whoever subscribes gets their reports.

        Raises LiveBusError, DeviceFeedError, ControlError.
        """
        self._clock = clock
        self.late_steps = 0
        self.lost_ns = 0
        self.steps = 0
        self._world = world
        self._control_server = ControlServer(control_port(base_port), world, phones, cameras)
        self._wirings = [
            VehicleWiring(vehicle_id, ports_of(number, base_port), folder, clock)
            for number, vehicle_id in enumerate(world.vehicle_ids)
        ]
        for vehicle_id in world.vehicle_ids:
            watch = world.module(vehicle_id).watch
            watch.gap_ns_min, watch.timeout_ns = frame_gap_ns, LIVE_COMMAND_TIMEOUT_NS
        self._moments = MomentFile(moment_path(folder), create=True)
        self._due_ns = clock.now_ns() + STEP_NS
        self._stopping = False

    def stop(self) -> None:
        self._stopping = True

    def run(self) -> None:
        """Run until `stop`."""
        while not self._stopping:
            self._wait()
            self.run_step()
        self.close()

    def run_step(self) -> None:
        """One step that ends at the due time."""
        due_ns = self._due_ns
        for wiring in self._wirings:
            self._world.frames_from_vehicle(wiring.vehicle_id, tuple(wiring.bus.take()))
        self._world.step(due_ns - STEP_NS)
        for wiring in self._wirings:
            wiring.exchange(self._world, due_ns)
        if self.steps % MOMENT_EVERY_STEPS == 0:
            self._moments.write(self._moment(due_ns))
        self._control_server.step(due_ns, self.steps % SCORES_EVERY_STEPS == 0)
        self.steps += 1
        self._due_ns = due_ns + STEP_NS

    def close(self) -> None:
        for wiring in self._wirings:
            wiring.close()
        self._control_server.close()
        self._moments.close()

    def _moment(self, now_ns: int) -> Moment:
        poses = [self._world.truth(vehicle_id).pose_map for vehicle_id in self._world.vehicle_ids]
        rows = np.array([(pose.x_m, pose.y_m, pose.yaw_rad) for pose in poses])
        return Moment(now_ns, rows, self._world.all_bodies())

    def _wait(self) -> None:
        pause_ns = self._due_ns - self._clock.now_ns()
        if pause_ns > 0:
            self._clock.wait(self._due_ns)
            return
        self.late_steps += pause_ns < -STEP_NS
        if pause_ns < -LATE_MAX_NS:
            self.lost_ns -= pause_ns
            self._due_ns -= pause_ns


def scan_ring_path(folder: Path, vehicle_id: str) -> Path:
    """The file of a vehicle's scan ring."""
    return folder / f"{vehicle_id}.scans"
