"""The perception worker as a process of its own: a ring of scans in; percepts and scans to look at out."""

import multiprocessing
import time
from collections.abc import Iterator
from multiprocessing.process import BaseProcess
from pathlib import Path

import numpy as np
import pytest

from campusloop.shipped import PROFILES
from tests.vehicle_agent.perception import test_height_map
from tests.vehicle_agent.perception.tracking.test_below_beams import roof_worker
from vehicle_agent.config import load_profile
from vehicle_agent.device_feed import DatagramPort, ScanRing
from vehicle_agent.runtime.processes.clock import MONOTONIC
from vehicle_agent.runtime.processes.mailbox import Deliveries, Mailbox
from vehicle_agent.runtime.processes.sensing.worker_process import ScannedVehicle, serve_percepts
from vehicle_agent.signals import ObstaclePercept, ThinnedScan, TrackPercept
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

    def write(self, stamp_ns: int, points: np.ndarray | None = None) -> None:
        points = a_scan() if points is None else points
        ready = self.ring.write(self.number, stamp_ns, points, np.zeros(len(points), np.float32))
        self.number += 1
        self.feed.send(self.port, ready)

    def close(self) -> None:
        self.feed.close()
        self.tick.close()
        self.gate.close()


def posted(mailbox: Mailbox) -> list[object]:
    return [item.body for mail in mailbox.take() if isinstance(mail, Deliveries) for item in mail.items]


Stamped = type[ObstaclePercept] | type[ThinnedScan] | type[TrackPercept]


def stamps(bodies: list[object], kind: Stamped) -> list[int]:
    return [body.stamp_ns for body in bodies if isinstance(body, kind)]


def until_seen(mailbox: Mailbox, kind: Stamped, stamp_ns: int) -> list[object]:
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


def serve_under_the_roof(folder: str, port: int) -> None:
    place = Path(folder)
    vehicle = ScannedVehicle("shuttle-1", place / "mail", port, place / "scans", roof_worker())
    serve_percepts((vehicle,), MONOTONIC.open("worker"))


class WorkerUnderTheRoof:
    """A worker process that is shown a child of 1.2 m, who is below all beams from 7 m on."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.stamp_ns = folder, SECOND_NS
        free = DatagramPort()
        self.port = free.port
        free.close()
        self.driver = Driver(folder, self.port)
        self.process = self._started()

    def _started(self) -> BaseProcess:
        context = multiprocessing.get_context("spawn")
        process = context.Process(target=serve_under_the_roof, args=(str(self.folder), self.port))
        process.start()
        return process

    def begin(self, x_m: float) -> None:
        """Until the process, which opens its port when it is ready, answers a scan."""
        until_s = time.monotonic() + WITHIN_S
        while not stamps(posted(self.driver.tick), TrackPercept):
            assert time.monotonic() < until_s, "the process has not begun"
            self._write(x_m)
            time.sleep(0.2)

    def people(self, x_m: float) -> int:
        """How many are tracked when the child stands at x_m."""
        self._write(x_m)
        told = until_seen(self.driver.tick, TrackPercept, self.stamp_ns)
        tracks = [one for one in told if isinstance(one, TrackPercept) and one.stamp_ns == self.stamp_ns]
        return len(tracks[0].ids)

    def _write(self, x_m: float) -> None:
        self.stamp_ns += 100_000_000
        self.driver.write(self.stamp_ns, test_height_map.a_scan([(x_m, 0.2, 0.4, 1.2)]))

    def kill(self) -> None:
        self.process.kill()
        self.process.join(WITHIN_S)

    def restart(self) -> None:
        self.process = self._started()

    def close(self) -> None:
        self.process.terminate()
        self.process.join(WITHIN_S)
        self.driver.close()


@pytest.fixture
def under_the_roof(tmp_path: Path) -> Iterator[WorkerUnderTheRoof]:
    made = WorkerUnderTheRoof(tmp_path)
    yield made
    made.close()


def test_a_killed_worker_that_is_started_again_knows_who_stands_before_the_bumper(
    under_the_roof: WorkerUnderTheRoof,
) -> None:
    worker = under_the_roof
    worker.begin(10.0)
    shown = [worker.people(max(5.0, 10.0 - 0.1 * k)) for k in range(1, 70)]
    assert shown[-1] == 1
    worker.kill()
    worker.restart()
    worker.begin(5.0)
    assert [worker.people(5.0) for _ in range(10)] == [1] * 10
    # Without what was kept, the child is not there for it.
    worker.kill()
    (worker.folder / "mail" / "below_beams.json").unlink()
    worker.restart()
    worker.begin(5.0)
    assert worker.people(5.0) == 0


def test_a_memory_that_cannot_be_read_stops_no_worker(under_the_roof: WorkerUnderTheRoof) -> None:
    worker = under_the_roof
    worker.begin(30.0)
    worker.kill()
    (worker.folder / "mail" / "below_beams.json").write_bytes(b"{half")
    worker.restart()
    worker.begin(30.0)
    assert worker.process.is_alive()
