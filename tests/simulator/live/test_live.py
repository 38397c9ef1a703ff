"""The simulation on real sockets, stepped by hand so that nothing depends on the machine's pace."""

import socket
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from contract.geometry import Pose2
from contract.roads.model import ObservationArea
from simulator.control import (
    CameraReported,
    PersonPlaced,
    RideAssigned,
    RiderComes,
    RiderLeft,
    RiderTapped,
    ScoreReport,
    SeatPressed,
    StopButton,
    Subscribe,
    decode_from_simulation,
    encode,
)
from simulator.infrastructure import CameraParams, CrossingCamera
from simulator.live.bus import LiveBus, LiveBusError, channel_of
from simulator.live.control_server import ControlError, ControlServer, RemotePhones
from simulator.live.live import LiveSimulation, scan_ring_path
from simulator.live.ports import VEHICLES_MAX, ports_of
from simulator.traffic.population import TrafficParams
from simulator.world import SimWorld, WorldOptions
from tests.simulator.street import street
from vehicle_agent.can.pacmod.codec import pacmod
from vehicle_agent.config import Profile
from vehicle_agent.device_feed import DatagramPort, DeviceOutputs, DeviceSensors, ScanReady, ScanRing
from vehicle_agent.signals import Actuation, DoorState, GnssFix, HmiOutput

BASE_PORT = 48_310
HOST = "127.0.0.1"


def a_world(phones: RemotePhones, options: WorldOptions) -> SimWorld:
    poses = {"s1": Pose2(20.0, 0.0, 0.0)}
    return SimWorld(street(), {"s1": Profile()}, poses, 1, phones, options)


class Listener:
    """Somebody at the control port."""

    def __init__(self, port: int) -> None:
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.bind((HOST, 0))
        self._socket.setblocking(False)
        self._port = port

    def send(self, *messages: object) -> None:
        for message in messages:
            self._socket.sendto(encode(message), (HOST, self._port))

    def send_bytes(self, data: bytes) -> None:
        self._socket.sendto(data, (HOST, self._port))

    def receive(self) -> list[object]:
        received: list[object] = []
        while True:
            try:
                received.append(decode_from_simulation(self._socket.recv(60_000)))
            except BlockingIOError:
                return received

    def close(self) -> None:
        self._socket.close()


class ControlRig:
    """A control server over a world without people, and one subscriber."""

    def __init__(self, cameras: tuple[CrossingCamera, ...] = ()) -> None:
        self.phones = RemotePhones()
        self.world = a_world(self.phones, WorldOptions(traffic=TrafficParams(), lidar=False))
        self.server = ControlServer(BASE_PORT, self.world, self.phones, cameras)
        self.listener = Listener(BASE_PORT)

    def close(self) -> None:
        self.server.close()
        self.listener.close()


@pytest.fixture
def rig() -> Iterator[ControlRig]:
    rig = ControlRig()
    yield rig
    rig.close()


def test_interventions_reach_the_world(rig: ControlRig) -> None:
    rig.listener.send(StopButton("s1", True), SeatPressed("s1", 1), PersonPlaced(70.0, 3.0))
    rig.server.step(0, report_scores=False)
    assert rig.world.module("s1").stop_pressed
    assert rig.world.people_near("s1", 100.0).tolist() == [[70.0, 3.0]]
    assert rig.server.refused == 0


def test_nonsense_and_unknown_vehicles_are_counted_and_change_nothing(rig: ControlRig) -> None:
    rig.listener.send(StopButton("nobody", True))
    rig.listener.send_bytes(b"\xc1")
    rig.server.step(0, report_scores=False)
    assert rig.server.refused == 2
    assert not rig.world.module("s1").stop_pressed


def test_a_rider_booked_from_outside_rides_and_is_reported(rig: ControlRig) -> None:
    here, there = Pose2(20.0, 0.0, 0.0), Pose2(22.0, 0.0, 0.0)
    rig.listener.send(Subscribe(), RiderComes("r1", "", 1, "tap", here, there), RideAssigned("r1", "s1"))
    rig.server.step(0, report_scores=False)
    rig.world.show("s1", HmiOutput("", "", "", "", True), 0)
    received: list[object] = []
    for k in range(800):
        rig.world.sensor_items("s1", k * 20_000_000)
        rig.server.step(k * 20_000_000, report_scores=False)
        received.extend(rig.listener.receive())
    assert received == [RiderTapped("r1", "board"), RiderTapped("r1", "alight"), RiderLeft("r1")]


def test_what_a_crossing_s_camera_sees_goes_to_subscribers() -> None:
    outline = ((69.0, 2.0), (71.0, 2.0), (71.0, 4.0), (69.0, 4.0))
    area = ObservationArea("crossing-1", "crossing", outline, ())
    exact = CameraParams(miss=0.0, ghost=0.0, dropout=0.0)
    rig = ControlRig((CrossingCamera(area, exact, np.random.default_rng(1)),))
    rig.listener.send(Subscribe(), PersonPlaced(70.0, 3.0))
    for k in range(30):
        rig.server.step(k * 20_000_000, report_scores=False)
    reports = rig.listener.receive()
    rig.close()
    assert [type(message) for message in reports] == [CameraReported] * 3
    assert {message.count for message in reports if isinstance(message, CameraReported)} == {1}


def test_scores_go_to_subscribers_only(rig: ControlRig) -> None:
    rig.server.step(0, report_scores=True)
    assert rig.listener.receive() == []
    rig.listener.send(Subscribe())
    rig.server.step(0, report_scores=True)
    reports = rig.listener.receive()
    assert [type(message) for message in reports] == [ScoreReport]


def test_a_second_simulation_on_the_same_port_is_refused(rig: ControlRig) -> None:
    with pytest.raises(ControlError, match="--base-port"):
        ControlServer(BASE_PORT, rig.world, rig.phones)


def test_every_vehicle_has_channels_and_ports_of_its_own() -> None:
    wirings = [ports_of(number) for number in range(VEHICLES_MAX)]
    numbers = [port for w in wirings for port in (w.values_port, w.scans_port, w.hmi_port)]
    assert len(set(numbers)) == 3 * VEHICLES_MAX
    assert len({w.can_channel for w in wirings}) == VEHICLES_MAX
    with pytest.raises(ValueError, match=str(VEHICLES_MAX)):
        ports_of(VEHICLES_MAX)
    with pytest.raises(LiveBusError, match="at most"):
        channel_of(300, 47_000)


@pytest.mark.real
def test_a_vehicle_drives_over_real_sockets(tmp_path: Path) -> None:
    phones = RemotePhones()
    world = a_world(phones, WorldOptions(traffic=None))
    simulation = LiveSimulation(world, phones, tmp_path, BASE_PORT + 1000)
    ports = ports_of(0, BASE_PORT + 1000)
    bus, sensors = LiveBus(ports.can_channel), DeviceSensors(ports.values_port)
    scans, ring = DatagramPort(ports.scans_port), ScanRing(scan_ring_path(tmp_path, "s1"), create=False)
    can = pacmod(Profile())
    state = can.initial()
    values: list[object] = []
    whole_scans = 0
    scans.send(ports.hmi_port, DeviceOutputs(HmiOutput("", "", "", "", True)))
    for _ in range(150):
        now_ns = time.monotonic_ns()
        motion, state = can.decode(state, tuple(bus.take()), now_ns)
        commands, state = can.encode(state, Actuation(True, "drive", 0.0, 0.6, 0.0), now_ns)
        for frame in commands:
            bus.send((frame,))
            time.sleep(0.0003)
        time.sleep(max(0.0, 0.018 - (time.monotonic_ns() - now_ns) * 1e-9))
        simulation._wait()
        simulation.run_step()
        values.extend(body for _, body in sensors.poll())
        whole_scans += sum(
            ring.read(ready) is not None for ready in scans.take() if isinstance(ready, ScanReady)
        )
    assert motion.enabled
    assert motion.speed_mps > 0.5
    assert sum(isinstance(value, GnssFix) for value in values) >= 140
    assert any(isinstance(value, DoorState) for value in values)
    assert whole_scans >= 25
    for closed in (simulation, bus, sensors, scans):
        closed.close()
