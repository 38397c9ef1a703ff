"""Cameras at simulated crossings whose counts come from a people detector on their pictures."""

from collections.abc import Callable

from campusloop.crossing_cameras.ground_pixels import GroundPixels
from campusloop.crossing_cameras.people_counter import CounterParams, PeopleCounter
from contract.roads.areas import outline_array
from contract.roads.model import ObservationArea
from simulator.sensors.cameras.crossing_view import CrossingView
from simulator.sensors.cameras.light import DAY, Light
from simulator.sensors.scene.static_scene import StaticScene
from simulator.traffic.actors import Bodies
from simulator.world import FLEET_NUMBERS_FROM
from vehicle_agent.perception.camera.conditions import CameraCondition, CameraRules

# A person whom the pictures lose is counted for so long: three pictures of the paper's 5 Hz.
_KEEP_S = 0.6


def detector_at(
    area: ObservationArea,
    scene: StaticScene,
    bodies: Callable[[], Bodies],
    seed: int,
    light: Light = DAY,
    rate_hz: float = 5.0,
) -> Callable[[int], int | None]:
    """`detect` of a `CrossingCamera`: renders the picture of the area as the world is now, and counts.

    bodies   of the world; rate_hz: of the pictures, so that a person who is lost is kept equally long
    Raises CameraLibraryMissing without OpenCV.
    """
    view = CrossingView(scene, area, seed, FLEET_NUMBERS_FROM, light)
    points = view.ground_points
    ground = GroundPixels([pixel for pixel, _ in points], [place for _, place in points])
    keep_pictures = max(1, round(_KEEP_S * rate_hz))
    counter = PeopleCounter(ground, outline_array(area), CounterParams(keep_pictures=keep_pictures))
    rules, condition = CameraRules(), CameraCondition(area.area_id)

    def detect(taken_ns: int) -> int | None:
        nonlocal condition
        picture = view.take(taken_ns, bodies()).picture
        condition = rules.after_picture(condition, picture)
        count = counter.count(picture.pixels)
        return count if condition.state == "good" else None

    return detect
