"""The replay plays what the cameras recorded at the moment that it shows."""

import hashlib
from pathlib import Path

import numpy as np
import pytest
from playwright.sync_api import Page, expect

from contract.video import SEGMENT_HEADER, SegmentName, signed_video, video_path
from contract.wire.upload import SIGNATURE_HEADER
from tests.e2e.conftest import WITHIN_MS, OpenPage
from tests.e2e.operator import sign_in
from tests.e2e.recorded_run import UTC_OFFSET_NS, record_run, upload_run
from tests.e2e.scripted_shuttle import ScriptedShuttle
from tests.e2e.server_process import ServerProcess
from vehicle_agent.runtime.video.segment_file import SegmentFile

pytestmark = pytest.mark.browser
av = pytest.importorskip("av", reason="PyAV is not installed (make video)")

SECONDS = 20
BRIGHTER_EACH_SECOND = 10
BRIGHTNESS = """async (video) => {
  const canvas = document.createElement('canvas');
  canvas.width = canvas.height = 8;
  const context = canvas.getContext('2d');
  context.drawImage(video, 0, 0, 8, 8);
  return context.getImageData(4, 4, 1, 1).data[0];
}"""

AT_SECOND = """(at_s) => {
  const video = document.querySelector('.run-video video');
  return video && video.readyState >= 2 && !video.seeking && Math.abs(video.currentTime - at_s) < 0.6;
}"""


def record_video(folder: Path) -> Path:
    """Its brightness tells the second of the run."""
    name = SegmentName("front", 1_000_000_000, UTC_OFFSET_NS + 1_000_000_000)
    file = SegmentFile(folder, name, (160, 120), 10.0, 200)
    for number in range(10 * (SECONDS - 1)):
        stamp_ns = name.stamp_ns + number * 100_000_000
        level = 20 + BRIGHTER_EACH_SECOND * (stamp_ns // 1_000_000_000)
        pixels = np.full((120, 160, 3), level, np.uint8)
        frame = av.VideoFrame.from_ndarray(pixels, format="rgb24").reformat(format="yuv420p")
        file.add(stamp_ns, frame)
    return file.close()


def upload_video(shuttle: ScriptedShuttle, path: Path, server: ServerProcess) -> None:
    data = path.read_bytes()
    sha256 = hashlib.sha256(data).hexdigest()
    signature = shuttle.sign(signed_video(shuttle.vehicle_id, sha256, path.name))
    headers = {
        "Vehicle-Id": shuttle.vehicle_id,
        SIGNATURE_HEADER: signature,
        SEGMENT_HEADER: path.name,
    }
    url = f"{server.http.base_url.copy_with(path=video_path(sha256))}"
    answer = server.http.put(url, content=data, headers=headers)
    assert answer.is_success, answer.text


def second_shown(page: Page) -> float:
    """By the brightness of the video's picture."""
    level = page.locator(".run-video video").evaluate(BRIGHTNESS)
    return (float(level) - 20) / BRIGHTER_EACH_SECOND


def test_the_video_shows_the_moment_of_the_replay(
    open_page: OpenPage, server: ServerProcess, shuttle: ScriptedShuttle, tmp_path: Path
) -> None:
    record_run(tmp_path / "0.mcap", "shuttle-1", "boot-41", server.network, seconds=SECONDS)
    upload_run(shuttle, tmp_path / "0.mcap", server.http)
    upload_video(shuttle, record_video(tmp_path / "video"), server)
    page = open_page("/console")
    sign_in(page)
    page.get_by_role("link", name="Runs").click()
    page.locator("a[href*='boot-41']").click()
    page.get_by_role("button", name="Show the video").click()
    slider = page.get_by_label("Time in the run")
    expect(page.get_by_text("No video at this moment.")).to_be_visible()
    for share in (0.8, 0.35):
        slider.evaluate(
            "(range, part) => { range.value = Number(range.min) + (range.max - range.min) * part;"
            " range.dispatchEvent(new Event('input', { bubbles: true })); }",
            share,
        )
        page.wait_for_function(AT_SECOND, arg=share * SECONDS - 1.0, timeout=WITHIN_MS)
        page.wait_for_timeout(200)
        assert second_shown(page) == pytest.approx(share * SECONDS, abs=1.3)
