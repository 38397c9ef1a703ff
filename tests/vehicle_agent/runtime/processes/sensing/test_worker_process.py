"""The perception worker as a process of its own: a ring of scans in; percepts and scans to look at out."""

import multiprocessing
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from campusloop.shipped import PROFILES
from vehicle_agent.config import load_profile
from vehicle_agent.device_feed import DatagramPort, ScanRing
from vehicle_agent.runtime.processes.clock import MONOTONIC
from vehicle_agent.runtime.processes.mailbox import Deliveries, Mailbox
from vehicle_agent.runtime.processes.sensing.worker_process import ScannedVehicle, serve_percepts
from vehicle_agent.signals import ObstaclePercept, ThinnedScan
from vehicle_agent.stacks.choice import build_perception_worker

SECOND_NS = 1_000_000_000
WITHIN_S = 60.0


def serve(folder: str, port: int) -> None:
    place = Path(folder)
    perception = build_perception_worker(load_profile(PROFILES / "campus-shuttle.toml"))
    vehicle = ScannedVehicle("shuttle-1", place / "mail", port, place / "scans", perception)
    serve_percepts((vehicle,), MONOTONIC.open("worker"))


def a_scan() -> np.ndarray:
    """Level road, and a box of 1 m ten metres ahead."""
    x, y = np.meshgrid(np.arange(-20.0, 20.0, 0.2), np.arange(-10.0, 10.0, 0.2))
    road = np.column_stack((x.ravel(), y.ravel(), np.zeros(x.size)))
    y, z = np.meshgrid(np.arange(-0.5, 0.5, 0.1), np.arange(0.1, 1.0, 0.1))
    box = np.column_stack((np.full(y.size, 10.0), y.ravel(), z.ravel()))
    return np.concatenate((road, box)).astype(np.float32)


class Driver:
    """Writes scans into the ring, announces them, and reads what the process posts."""

    def __init__(self, folder: Path, port: int) -> None:
        self.ring, self.feed = ScanRing(folder / "scans", create=True), DatagramPort()
        self.port, self.number = port, 0
        self.tick, self.gate = Mailbox(folder / "mail" / "tick"), Mailbox(folder / "mail" / "gate")

    def write(self, stamp_ns: int) -> None:
        points = a_scan()
        ready = self.ring.write(self.number, stamp_ns, points, np.zeros(len(points), np.float32))
        self.number += 1
        self.feed.send(self.port, ready)

    def close(self) -> None:
        self.feed.close()
        self.tick.close()
        self.gate.close()


def posted(mailbox: Mailbox) -> list[object]:
    return [item.body for mail in mailbox.take() if isinstance(mail, Deliveries) for item in mail.items]


def stamps(bodies: list[object], kind: type[ObstaclePercept] | type[ThinnedScan]) -> list[int]:
    return [body.stamp_ns for body in bodies if isinstance(body, kind)]


def until_seen(
    mailbox: Mailbox, kind: type[ObstaclePercept] | type[ThinnedScan], stamp_ns: int
) -> list[object]:
    """What comes up to this."""
    found: list[object] = []
    until_s = time.monotonic() + WITHIN_S
    while stamp_ns not in stamps(found, kind):
        assert time.monotonic() < until_s, f"no {kind} of {stamp_ns}: {found}"
        time.sleep(0.01)
        found += posted(mailbox)
    return found


@pytest.fixture
def driver(tmp_path: Path) -> Iterator[Driver]:
    free = DatagramPort()
    port = free.port
    free.close()
    made = Driver(tmp_path, port)
    process = multiprocessing.get_context("spawn").Process(target=serve, args=(str(tmp_path), port))
    process.start()
    yield made
    process.terminate()
    process.join(WITHIN_S)
    assert process.exitcode == 0, "it ends in order"
    made.close()


def test_each_scan_goes_to_tick_and_gate_and_one_a_second_to_those_who_look(driver: Driver) -> None:
    until_s = time.monotonic() + WITHIN_S
    seen: list[object] = []
    # The process opens its port when it is ready: what is announced before is lost, as on a vehicle.
    while not seen:
        assert time.monotonic() < until_s, "the process has not begun"
        driver.write(SECOND_NS)
        time.sleep(0.2)
        seen = posted(driver.tick)
    assert posted(driver.gate)
    told: list[object] = []
    for stamp_ns in (2 * SECOND_NS, 2 * SECOND_NS + 100_000_000, 3 * SECOND_NS):
        driver.write(stamp_ns)
        told += until_seen(driver.tick, ObstaclePercept, stamp_ns)
        until_seen(driver.gate, ObstaclePercept, stamp_ns)
    if 3 * SECOND_NS not in stamps(told, ThinnedScan):
        told += until_seen(driver.tick, ThinnedScan, 3 * SECOND_NS)
    shown = [stamp_ns for stamp_ns in stamps(told, ThinnedScan) if stamp_ns > SECOND_NS]
    assert shown == [2 * SECOND_NS, 3 * SECOND_NS]
