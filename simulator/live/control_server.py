"""Receives and sends the `simulator.control` messages of a running simulation."""

import socket
from typing import Literal

import msgspec

from simulator.control import (
    CameraReported,
    FromSimulation,
    RideAssigned,
    RiderComes,
    RiderLeft,
    RiderTapped,
    ScoreReport,
    Subscribe,
    ToSimulation,
    decode_to_simulation,
    encode,
)
from simulator.infrastructure import CrossingCamera
from simulator.riders import Rider
from simulator.scenario import intervene
from simulator.world import SimWorld, WorldError

HOST = "127.0.0.1"
DATAGRAM_BYTES_MAX = 60_000
Address = tuple[str, int]


class ControlError(Exception):
    """The control port cannot be opened; the message says what to do."""


class RemotePhones:
    """All riders' phones: `RideAssigned` sets what they show, `RiderTapped` reports each tap."""

    def __init__(self) -> None:
        self.vehicles: dict[str, str] = {}
        self.taps: list[RiderTapped] = []

    def vehicle_of(self, ride_id: str) -> str:
        return self.vehicles.get(ride_id, "")

    def tap(self, ride_id: str, kind: Literal["board", "alight"]) -> None:
        self.taps.append(RiderTapped(ride_id, kind))


class ControlServer:
    """Serves one world. refused: number of messages that were invalid or named unknown vehicles or rides."""

    def __init__(
        self, port: int, world: SimWorld, phones: RemotePhones, cameras: tuple[CrossingCamera, ...] = ()
    ) -> None:
        self.refused = 0
        self._world, self._phones, self._cameras = world, phones, cameras
        self._subscribers: dict[Address, None] = {}
        self._riding: dict[str, None] = {}
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.setblocking(False)
        try:
            self._socket.bind((HOST, port))
        except OSError as error:
            self._socket.close()
            raise ControlError(
                f"port {port} is taken ({error}); end the other simulation or choose another --base-port"
            ) from error

    def step(self, now_ns: int, report_scores: bool) -> None:
        """Execute the messages since the last call, and send reports to the subscribers."""
        for data, address in self._received():
            try:
                message = decode_to_simulation(data)
                self._execute(message, address, now_ns)
            except (msgspec.DecodeError, KeyError, ValueError, WorldError):
                self.refused += 1
        self._report(self._phones.taps)
        self._phones.taps = []
        left = [ride_id for ride_id in self._riding if self._world.riders.is_gone(ride_id)]
        for ride_id in left:
            del self._riding[ride_id]
        self._report([RiderLeft(ride_id) for ride_id in left])
        self._report_cameras(now_ns)
        if report_scores and self._subscribers:
            self._report([self._score(vehicle_id) for vehicle_id in self._world.vehicle_ids])

    def close(self) -> None:
        self._socket.close()

    def _received(self) -> list[tuple[bytes, Address]]:
        received: list[tuple[bytes, Address]] = []
        while True:
            try:
                received.append(self._socket.recvfrom(DATAGRAM_BYTES_MAX))
            except BlockingIOError:
                return received

    def _execute(self, message: ToSimulation, address: Address, now_ns: int) -> None:
        world = self._world
        match message:
            case Subscribe():
                self._subscribers[address] = None
            case RiderComes(ride_id, code, party, how, from_map, to_map):
                world.riders.add(Rider(ride_id, code, party, how, from_map, to_map, now_ns))
                self._riding[ride_id] = None
            case RideAssigned(ride_id, vehicle_id):
                self._phones.vehicles[ride_id] = vehicle_id
            case _:
                intervene(world, message, now_ns)

    def _score(self, vehicle_id: str) -> ScoreReport:
        score = self._world.score(vehicle_id)
        return ScoreReport(
            vehicle_id,
            score.distance_m,
            score.contacts,
            score.encounters,
            score.stopped_for_people_s,
            score.hardest_braking_mps2,
        )

    def _report_cameras(self, now_ns: int) -> None:
        people = self._world.pedestrians
        if people is None:
            return
        for camera in self._cameras:
            for seen in camera.step(now_ns, people.places):
                self._send(CameraReported(seen.area_id, seen.count, seen.age_s))

    def _report(self, messages: list[RiderTapped] | list[RiderLeft] | list[ScoreReport]) -> None:
        for message in messages:
            self._send(message)

    def _send(self, message: FromSimulation) -> None:
        for address in self._subscribers:
            self._socket.sendto(encode(message), address)
