"""From an operator's mark in the run log to the server: the video of that moment, once, and nothing else."""

import asyncio
import time
from pathlib import Path

import httpx
import msgspec
import numpy as np
import pytest

from contract.runlog.records import MARK_TOPIC, POSE_TOPIC, MarkKind, recording_mark
from contract.video import SEGMENT_HEADER, WEBM_BEGINS, name_of
from vehicle_agent.link.video_uploads import VideoUploads
from vehicle_agent.picture_ring import PictureRing
from vehicle_agent.runtime.processes.clock import MONOTONIC
from vehicle_agent.runtime.processes.link.video_marks import VideoMarks
from vehicle_agent.runtime.processes.mailbox import Mailbox
from vehicle_agent.runtime.processes.sensing.video_process import VideoProcess
from vehicle_agent.runtime.recording.recorder import LogEntry
from vehicle_agent.runtime.video.cameras_file import CameraEntry, RecordedCamera, VideoSettings


def mark(kind: MarkKind, at_ns: int, mark_id: str) -> LogEntry:
    return LogEntry(MARK_TOPIC, 0, msgspec.json.encode(recording_mark(at_ns, "note", kind, mark_id)))


def test_marks_wait_for_the_process_that_records(tmp_path: Path) -> None:
    link = Mailbox(tmp_path / "link")
    marks = VideoMarks(lambda one: link.post(tmp_path / "video", one))
    marks.pass_on([mark("mark", 5, "a"), LogEntry(POSE_TOPIC, 0, b"{}")])
    later = Mailbox(tmp_path / "video")
    marks.pass_on([mark("stop_recording", 9, "b")])
    marks.pass_on([])
    assert [one.mark_id for one in later.take()] == ["a", "b"]  # type: ignore[union-attr]
    link.close()
    later.close()


def test_the_video_of_a_recording_reaches_the_server_and_no_other(tmp_path: Path) -> None:
    pytest.importorskip("av", reason="PyAV is not installed (make video)")
    ring, rng = PictureRing(tmp_path / "ring", create=True), np.random.default_rng(1)
    camera = RecordedCamera("front", CameraEntry("ring", 160, 120), str(tmp_path / "ring"))
    process = VideoProcess(VideoSettings((camera,), 1), tmp_path / "video", MONOTONIC, tmp_path / "mail")
    link = Mailbox(tmp_path / "mail" / "link")
    marks = VideoMarks(lambda one: link.post(tmp_path / "mail" / "video", one))
    begun_ns: int | None = None
    for number in range(46):
        ring.write(time.monotonic_ns(), rng.integers(0, 255, (120, 160, 3), dtype=np.uint8))
        time.sleep(0.1)
        if number == 25:
            begun_ns = time.time_ns()
            marks.pass_on([mark("start_recording", begun_ns, "a")])
        if number == 30:
            marks.pass_on([mark("stop_recording", time.time_ns(), "b")])
        process.look()
    process.close()
    link.close()
    assert begun_ns is not None
    received: list[str] = []

    def answer(request: httpx.Request) -> httpx.Response:
        assert request.content.startswith(WEBM_BEGINS)
        assert request.headers["Vehicle-Signature"] == "signed"
        received.append(request.headers[SEGMENT_HEADER])
        return httpx.Response(503 if len(received) == 1 else 201)

    async def upload() -> None:
        client = httpx.AsyncClient(transport=httpx.MockTransport(answer), base_url="http://campus.test")
        uploads = VideoUploads("shuttle-1", tmp_path / "video" / "outgoing", client, lambda _: "signed")
        assert not await uploads.upload_waiting()
        assert await uploads.upload_waiting()
        assert await uploads.upload_waiting()

    asyncio.run(upload())
    assert received[0] == received[1]
    sent = [name_of(text) for text in received[1:]]
    assert len(set(received)) == len(sent) <= 3
    for name in sent:
        assert name is not None
        assert name.end_utc_ns >= begun_ns
        assert name.utc_ns <= begun_ns + 2_000_000_000
    assert list((tmp_path / "video" / "outgoing").iterdir()) == []
