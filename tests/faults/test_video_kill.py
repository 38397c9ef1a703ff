"""The recorder is killed: what it leaves plays up to the last two seconds, and the next start goes on."""

import multiprocessing
import os
import signal
import time
from pathlib import Path

import numpy as np
import pytest

from vehicle_agent.picture_ring import PictureRing
from vehicle_agent.runtime.processes.clock import MONOTONIC
from vehicle_agent.runtime.processes.sensing.video_process import VideoProcess, serve_video
from vehicle_agent.runtime.video.cameras_file import CameraEntry, RecordedCamera, VideoSettings
from vehicle_agent.runtime.video.segment_names import segments_in

av = pytest.importorskip("av", reason="PyAV is not installed (make video)")
pytestmark = pytest.mark.faults


def test_a_kill_loses_two_seconds_at_most(tmp_path: Path) -> None:
    ring, video, rng = (
        PictureRing(tmp_path / "ring", create=True),
        tmp_path / "video",
        np.random.default_rng(1),
    )
    camera = RecordedCamera("front", CameraEntry("ring", 320, 240), str(tmp_path / "ring"))
    settings = VideoSettings((camera,), segment_s=300)
    recorder = multiprocessing.get_context("spawn").Process(
        target=serve_video, args=(settings, video, MONOTONIC)
    )
    recorder.start()
    assert recorder.pid is not None
    begun_s: float | None = None
    deadline_s = time.monotonic() + 60.0
    while begun_s is None or time.monotonic() - begun_s < 4.3:
        assert time.monotonic() < deadline_s, "the recorder has not begun"
        ring.write(time.monotonic_ns(), rng.integers(0, 255, (240, 320, 3), dtype=np.uint8))
        time.sleep(0.1)
        if begun_s is None and segments_in(video):
            begun_s = time.monotonic()
    os.kill(recorder.pid, signal.SIGKILL)
    killed_ns = time.monotonic_ns()
    recorder.join()
    (left,) = segments_in(video)
    with av.open(str(video / left.text())) as container:
        last_s = [frame.time for frame in container.decode(video=0)][-1]
    assert (killed_ns - left.stamp_ns) / 1e9 - last_s <= 2.0
    VideoProcess(settings, video, MONOTONIC).close()
    finished = segments_in(video)[0]
    assert finished.length_ms == pytest.approx(1000 * last_s, abs=1)
    assert (video / finished.text()).stat().st_size > 0
