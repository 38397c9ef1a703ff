"""The simulation on real sockets, stepped by hand so that nothing depends on the machine's pace."""

import socket
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from contract.geometry import Pose2
from simulator.control import (
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
from simulator.live.bus import LiveBus, LiveBusError, channel_of
from simulator.live.control_server import CarriedPhones, ControlError, ControlServer
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


def a_world(phones: CarriedPhones, options: WorldOptions) -> SimWorld:
    poses = {"s1": Pose2(20.0, 0.0, 0.0)}
    return SimWorld(street(), {"s1": Profile()}, poses, 1, phones, options)


class Listener:
    """Somebody at the control port."""

    def __init__(self, port: int) -> None:
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.bind((HOST, 0))
        self._socket.setblocking(False)
        self._port = port

    def say(self, *messages: object) -> None:
        for message in messages:
            self._socket.sendto(encode(message), (HOST, self._port))

    def say_bytes(self, data: bytes) -> None:
        self._socket.sendto(data, (HOST, self._port))

    def hear(self) -> list[object]:
        heard: list[object] = []
        while True:
            try:
                heard.append(decode_from_simulation(self._socket.recv(60_000)))
            except BlockingIOError:
                return heard

    def close(self) -> None:
        self._socket.close()


class Desk:
    """A control desk over a quiet world, and one listener."""

    def __init__(self) -> None:
        self.phones = CarriedPhones()
        self.world = a_world(self.phones, WorldOptions(traffic=TrafficParams(), lidar=False))
        self.desk = ControlServer(BASE_PORT, self.world, self.phones)
        self.listener = Listener(BASE_PORT)

    def close(self) -> None:
        self.desk.close()
        self.listener.close()


@pytest.fixture
def desk() -> Iterator[Desk]:
    desk = Desk()
    yield desk
    desk.close()


def test_interventions_reach_the_world(desk: Desk) -> None:
    desk.listener.say(StopButton("s1", True), SeatPressed("s1", 1), PersonPlaced(70.0, 3.0))
    desk.desk.step(0, tell_scores=False)
    assert desk.world.module("s1").stop_pressed
    assert desk.world.people_near("s1", 100.0).tolist() == [[70.0, 3.0]]
    assert desk.desk.refused == 0


def test_nonsense_and_unknown_vehicles_are_counted_and_change_nothing(desk: Desk) -> None:
    desk.listener.say(StopButton("nobody", True))
    desk.listener.say_bytes(b"\xc1")
    desk.desk.step(0, tell_scores=False)
    assert desk.desk.refused == 2
    assert not desk.world.module("s1").stop_pressed


def test_a_rider_booked_from_outside_rides_and_is_reported(desk: Desk) -> None:
    here, there = Pose2(20.0, 0.0, 0.0), Pose2(22.0, 0.0, 0.0)
    desk.listener.say(Subscribe(), RiderComes("r1", "", 1, "tap", here, there), RideAssigned("r1", "s1"))
    desk.desk.step(0, tell_scores=False)
    desk.world.show("s1", HmiOutput("", "", "", "", True), 0)
    heard: list[object] = []
    for k in range(800):
        desk.world.sensor_items("s1", k * 20_000_000)
        desk.desk.step(k * 20_000_000, tell_scores=False)
        heard.extend(desk.listener.hear())
    assert heard == [RiderTapped("r1", "board"), RiderTapped("r1", "alight"), RiderLeft("r1")]


def test_scores_go_to_subscribers_only(desk: Desk) -> None:
    desk.desk.step(0, tell_scores=True)
    assert desk.listener.hear() == []
    desk.listener.say(Subscribe())
    desk.desk.step(0, tell_scores=True)
    told = desk.listener.hear()
    assert [type(message) for message in told] == [ScoreReport]


def test_a_second_simulation_on_the_same_port_is_refused(desk: Desk) -> None:
    with pytest.raises(ControlError, match="--base-port"):
        ControlServer(BASE_PORT, desk.world, desk.phones)


def test_every_vehicle_has_channels_and_ports_of_its_own() -> None:
    wirings = [ports_of(number) for number in range(VEHICLES_MAX)]
    numbers = [port for w in wirings for port in (w.values_port, w.scans_port, w.words_port)]
    assert len(set(numbers)) == 3 * VEHICLES_MAX
    assert len({w.can_channel for w in wirings}) == VEHICLES_MAX
    with pytest.raises(ValueError, match=str(VEHICLES_MAX)):
        ports_of(VEHICLES_MAX)
    with pytest.raises(LiveBusError, match="at most"):
        channel_of(300, 47_000)


@pytest.mark.real
def test_a_vehicle_drives_over_real_sockets(tmp_path: Path) -> None:
    phones = CarriedPhones()
    world = a_world(phones, WorldOptions(traffic=None))
    simulation = LiveSimulation(world, phones, tmp_path, BASE_PORT + 1000)
    ports = ports_of(0, BASE_PORT + 1000)
    bus, sensors = LiveBus(ports.can_channel), DeviceSensors(ports.values_port)
    scans, ring = DatagramPort(ports.scans_port), ScanRing(scan_ring_path(tmp_path, "s1"), create=False)
    can = pacmod(Profile())
    state = can.initial()
    values: list[object] = []
    whole_scans = 0
    scans.send(ports.words_port, DeviceOutputs(HmiOutput("", "", "", "", True)))
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
