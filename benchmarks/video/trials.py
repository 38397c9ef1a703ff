"""The recorder beside a drive, and the recorder killed."""

import gc
import multiprocessing
import os
import shutil
import signal
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from multiprocessing.context import SpawnProcess
from pathlib import Path

import av
import numpy as np
import psutil

from benchmarks.video.pictures import play
from campusloop.virtual.solo_drive import SoloDrive
from contract.roads.load import load_map
from server.supervision.parent_end import end_with_parent
from simulator.traffic.population import TrafficParams
from vehicle_agent.runtime.processes.clock import MONOTONIC
from vehicle_agent.runtime.processes.pacing import Pacer
from vehicle_agent.runtime.processes.priority import TICK_PRIORITY, ask_for_real_time
from vehicle_agent.runtime.processes.sensing.video_process import serve_video
from vehicle_agent.runtime.video.cameras_file import CameraEntry, RecordedCamera, VideoSettings
from vehicle_agent.runtime.video.segment_names import segments_in

CAMERAS = ("front", "left", "right", "rear")
SPAWN = multiprocessing.get_context("spawn")


def _child(target: Callable[..., None], *arguments: object) -> SpawnProcess:
    """A started process that ends with this one, even if this one is killed."""
    process = SPAWN.Process(target=_run, args=(target, *arguments))
    process.start()
    return process


def _run(target: Callable[..., None], *arguments: object) -> None:
    end_with_parent()
    target(*arguments)


def drive(map_file: Path, folder: Path, seed: int, seconds: float, out: Path) -> None:
    """A shuttle's loop at 50 Hz on the wall clock; writes (n, 2): each tick's stamp and wall time, ns.

    With the tick process's priority, as on a vehicle, where the system allows it.
    """
    loop = SoloDrive(
        load_map(map_file), folder, seed, stops=30, traffic=TrafficParams(), lidar=False,
        start_ns=time.monotonic_ns(),
    )  # fmt: skip
    loop.set_off()
    loop.vehicle.times.whole.clear()
    gc.collect()
    gc.freeze()
    is_real_time = ask_for_real_time("tick", TICK_PRIORITY)
    pacer, stamps_ns = Pacer(), []
    end_ns = time.monotonic_ns() + round(seconds * 1e9)
    while (now_ns := pacer.wait()) < end_ns:
        stamps_ns.append(now_ns)
        loop.step(now_ns)
    gc.unfreeze()
    ticks_ns = np.column_stack((stamps_ns, loop.vehicle.times.whole))
    np.savez(out, ticks_ns=ticks_ns, is_real_time=is_real_time)
    loop.vehicle.shut_down()


class Driving:
    """A drive in a process of its own."""

    def __init__(self, map_file: Path, folder: Path, seed: int, seconds: float) -> None:
        folder.mkdir()
        self.is_real_time = False
        self._out = folder / "ticks.npz"
        self.process = _child(drive, map_file, folder, seed, seconds, self._out)

    def ticks(self) -> np.ndarray:
        """(n, 2) stamp and wall time of each tick, ns; waits for the drive's end."""
        self.process.join()
        if self.process.exitcode != 0:
            raise SystemExit("the drive has failed")
        with np.load(self._out) as written:
            self.is_real_time = bool(written["is_real_time"])
            ticks_ns: np.ndarray = written["ticks_ns"]
        return ticks_ns


def alternating(driving: Driving, recorded: "Recording", window_s: float) -> list[tuple[int, int, bool]]:
    """Stops and continues cameras and recorder in turn until the drive ends: (begin, end, it recorded), ns.

    Both kinds of windows lie among each other, so that other work on the machine meets both alike.
    """
    windows, is_on = [], True
    while driving.process.is_alive():
        begun_ns = time.monotonic_ns()
        driving.process.join(window_s)
        windows.append((begun_ns, time.monotonic_ns(), is_on))
        is_on = not is_on
        recorded.signal(signal.SIGCONT if is_on else signal.SIGSTOP)
    recorded.signal(signal.SIGCONT)
    return windows


@dataclass(slots=True)
class Recording:
    """folder: of the segments. cpu_s, wall_s: of the recorder, from `begin_count` to `end_count`."""

    folder: Path
    stamps: Path
    recorder: SpawnProcess
    player: SpawnProcess
    _cpu_s: float = 0.0
    _begun_s: float = 0.0
    cpu_s: float = 0.0
    wall_s: float = 0.0

    def begin_count(self) -> None:
        self._cpu_s, self._begun_s = _cpu_s(self.recorder), time.monotonic()

    def end_count(self) -> None:
        self.cpu_s = _cpu_s(self.recorder) - self._cpu_s
        self.wall_s = time.monotonic() - self._begun_s

    def signal(self, number: int) -> None:
        for process in (self.recorder, self.player):
            assert process.pid is not None
            os.kill(process.pid, number)

    def kill(self) -> int:
        """The moment of SIGKILL, ns."""
        assert self.recorder.pid is not None
        os.kill(self.recorder.pid, signal.SIGKILL)
        killed_ns = time.monotonic_ns()
        self.recorder.join()
        return killed_ns


@contextmanager
def recording(folder: Path, pictures: Path, seed: int, segment_s: int) -> Iterator[Recording]:
    """Four cameras that play pictures, and their recorder, which has begun."""
    folder.mkdir()
    # On a disk, the kernel would write every picture to it.
    memory = Path(tempfile.mkdtemp(dir="/dev/shm" if Path("/dev/shm").is_dir() else None))
    rings = {name: memory / f"{name}.ring" for name in CAMERAS}
    stop, stamps, video = SPAWN.Event(), folder / "stamps.npz", folder / "video"
    player = _child(play, pictures, rings, stamps, stop, seed)
    cameras = tuple(RecordedCamera(name, CameraEntry("ring"), str(path)) for name, path in rings.items())
    recorder = _child(serve_video, VideoSettings(cameras, segment_s), video, MONOTONIC)
    while len({one.camera for one in segments_in(video)}) < len(CAMERAS):
        time.sleep(0.1)
    yield Recording(video, stamps, recorder, player)
    if recorder.is_alive():
        recorder.terminate()
        recorder.join()
    stop.set()
    player.join()
    shutil.rmtree(memory)


def lost_pictures(one: Recording, ended_ns: int) -> tuple[int, int]:
    """(written by the cameras, not in any file), from the first recorded picture to the end."""
    stamps, written, lost = np.load(one.stamps), 0, 0
    for name in CAMERAS:
        mine = [segment for segment in segments_in(one.folder) if segment.camera == name]
        sent = np.count_nonzero((stamps[name] >= mine[0].stamp_ns) & (stamps[name] <= ended_ns))
        kept = 0
        for segment in mine:
            with av.open(str(one.folder / segment.text())) as container:
                kept += sum(packet.dts is not None for packet in container.demux(video=0))
        written, lost = written + int(sent), lost + max(0, int(sent) - kept)
    return written, lost


def seconds_lost(folder: Path, killed_ns: int) -> float:
    """From the last picture that can be decoded to the kill, of the camera that lost most."""
    worst_s = 0.0
    for segment in segments_in(folder):
        if segment.length_ms is not None:
            continue
        last_s = 0.0
        with av.open(str(folder / segment.text())) as container:
            for frame in container.decode(video=0):
                last_s = frame.time
        worst_s = max(worst_s, (killed_ns - segment.stamp_ns) / 1e9 - last_s)
    return worst_s


def _cpu_s(process: SpawnProcess) -> float:
    times = psutil.Process(process.pid).cpu_times()
    return float(times.user + times.system)
