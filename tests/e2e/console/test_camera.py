"""An operator looks through the cameras of a shuttle."""

from pathlib import Path

import numpy as np
import pytest
from playwright.sync_api import Locator, expect

from tests.e2e.conftest import OpenPage
from tests.e2e.operator import show_vehicle, sign_in
from tests.e2e.scripted_shuttle import ScriptedShuttle
from vehicle_agent.runtime.video.picture_taker import PictureTaker

pytestmark = pytest.mark.browser
av = pytest.importorskip("av", reason="PyAV is not installed (make video)")

# Another picture comes twice a second: a look at one that is not drawn yet is repeated.
BRIGHTNESS = """(image) => {
  if (!image.complete || image.naturalWidth !== 480 || image.naturalHeight !== 360) return null;
  const canvas = document.createElement('canvas');
  canvas.width = canvas.height = 8;
  const context = canvas.getContext('2d');
  context.drawImage(image, 0, 0, 8, 8);
  return context.getImageData(4, 4, 1, 1).data[0];
}"""


def picture(level: int) -> bytes:
    taker = PictureTaker(is_coarse=True)
    taker.until_ns = 2
    pixels = np.full((480, 640, 3), level, np.uint8)
    pixels[:, ::80] = 255 - level
    taker.offer(1, av.VideoFrame.from_ndarray(pixels, format="rgb24").reformat(format="yuv420p"))
    assert taker.newest is not None
    return taker.newest.jpeg


def brightness(image: Locator) -> float:
    for _ in range(100):
        found = image.evaluate(BRIGHTNESS)
        if found is not None:
            return float(found)
        image.page.wait_for_timeout(100)
    raise AssertionError("no picture of 480 x 360 was drawn")


def test_an_operator_looks_through_one_camera_and_then_another(
    open_page: OpenPage, shuttle: ScriptedShuttle, screenshots: Path | None
) -> None:
    shuttle.cameras = {"front": picture(60), "rear": picture(200), "roof": b""}
    console = open_page("/console")
    sign_in(console)
    panel = show_vehicle(console, "Shuttle 1")
    panel.get_by_text("Camera", exact=True).first.click()
    panel.get_by_role("button", name="Show a camera").click()
    image = panel.get_by_role("img", name="What the camera “front” sees")
    expect(image).to_be_visible()
    assert abs(brightness(image) - 60) < 6
    expect(panel).to_contain_text("no face and no plate can be read")
    if screenshots is not None:
        image.scroll_into_view_if_needed()
        console.screenshot(path=screenshots / "camera-live.png")
    panel.get_by_label("Camera", exact=True).select_option("rear")
    image = panel.get_by_role("img", name="What the camera “rear” sees")
    expect(image).to_be_visible()
    assert abs(brightness(image) - 200) < 6
    panel.get_by_label("Camera", exact=True).select_option("roof")
    expect(panel.get_by_text("The camera gives no picture.")).to_be_visible()
    expect(panel.get_by_role("img", name="What the camera")).to_have_count(0)
    console.get_by_role("link", name="Audit log").click()
    expect(console.get_by_text("ask_for_camera").first).to_be_visible()


def test_a_shuttle_without_cameras_says_so(open_page: OpenPage, shuttle: ScriptedShuttle) -> None:
    console = open_page("/console")
    sign_in(console)
    panel = show_vehicle(console, "Shuttle 1")
    panel.get_by_text("Camera", exact=True).first.click()
    panel.get_by_role("button", name="Show a camera").click()
    expect(panel.get_by_text("This shuttle has no cameras that it records.")).to_be_visible()


def test_before_a_blocked_shuttle_is_resumed_its_camera_is_shown(
    open_page: OpenPage, shuttle: ScriptedShuttle, screenshots: Path | None
) -> None:
    shuttle.cameras = {"front": picture(60), "rear": picture(200)}
    console = open_page("/console")
    sign_in(console)
    panel = show_vehicle(console, "Shuttle 1")
    shuttle.speed_mps, shuttle.obstacle_m = 0.0, 1.2
    expect(panel.locator(".chip").first).to_have_text("Blocked")
    shuttle.commanded.clear()
    panel.get_by_role("button", name="Resume").click()
    question = console.get_by_role("dialog", name="Resume Shuttle 1?")
    image = question.get_by_role("img", name="What the camera “front” sees")
    expect(image).to_be_visible()
    assert abs(brightness(image) - 60) < 6
    if screenshots is not None:
        console.screenshot(path=screenshots / "wave-on.png")
    question.get_by_role("button", name="Back").click()
    expect(question).to_have_count(0)
    console.wait_for_timeout(500)
    assert "resume" not in shuttle.commanded
