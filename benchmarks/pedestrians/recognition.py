"""How well OpenCV's people detector recognises simulated people, beside real ones of the same height."""

import math
from pathlib import Path

import numpy as np

from benchmarks.reporting.report import Row
from benchmarks.sensors.drive import way_over
from contract.geometry import Array, Pose2
from contract.roads.model import RoadMap
from simulator.sensors.cameras.camera import CameraSurroundings, SceneCamera
from simulator.sensors.cameras.clothed_people import PeopleDresser
from simulator.sensors.cameras.light import Light
from simulator.sensors.cameras.mounts import CameraMount
from simulator.sensors.scene.moving_scene import MovingScenes
from simulator.sensors.scene.static_scene import StaticScene
from simulator.traffic.actors import Bodies
from vehicle_agent.perception.camera.people_detector import HogPeopleDetector, opencv
from vehicle_agent.signals import PEDESTRIAN
from vehicle_agent.signals.pictures import optical_pose

cv2 = opencv()
# Of a person in the video, so that both are compared at the same size.
HEIGHT_PX = (40, 75)
_SIZES = (0.92, 1.0, 1.08)
_EVERY = 15
_FIRST = 100
_FLEET_FROM = 1_000_000
_PEOPLE = 8

# Rows (k, 2): height in pixels, score.
Scores = list[tuple[float, float]]


def real_scores(video: Path, shrink: float, detector: HogPeopleDetector) -> Scores:
    """Everything in the video that moves alone and has a person's outline, by its background.

    Raises SystemExit if the video cannot be read.
    """
    capture = cv2.VideoCapture(str(video))
    if not capture.isOpened():
        raise SystemExit(f"{video} is no video that OpenCV can read")
    background = cv2.createBackgroundSubtractorMOG2(300, 25, True)
    found: Scores = []
    number = 0
    while True:
        has_picture, pixels = capture.read()
        if not has_picture:
            return found
        number += 1
        moving = background.apply(pixels)
        if number < _FIRST or number % _EVERY:
            continue
        mask = (moving == 255).astype(np.uint8)
        mask = cv2.morphologyEx(mask, cv2.MORPH_CLOSE, np.ones((7, 3), np.uint8))
        mask = cv2.morphologyEx(mask, cv2.MORPH_OPEN, np.ones((3, 3), np.uint8))
        small = _shrunk(pixels, shrink)
        rows, columns = mask.shape
        for left, top, width, height, size in cv2.connectedComponentsWithStats(mask)[2][1:].tolist():
            is_person = HEIGHT_PX[0] <= height <= HEIGHT_PX[1] and 0.25 < width / height < 0.55
            is_whole = left > 5 and top > 5 and left + width < columns - 5 and top + height < rows - 5
            if is_person and is_whole and size > 0.4 * width * height:
                feet = ((left + 0.5 * width) * shrink, (top + height) * shrink)
                found.append((height * shrink, _best(detector, small, feet, height * shrink)))


def simulated_scores(
    road_map: RoadMap,
    scene: StaticScene,
    light: Light,
    shrink: float,
    detector: HogPeopleDetector,
    seeds: range,
) -> Scores:
    """People before a camera on a mast of 6 m, as far away as the video's; those whom nothing overlaps."""
    found: Scores = []
    scenes, dresser = MovingScenes(scene.ground, _FLEET_FROM), PeopleDresser(scene.ground)
    for seed in seeds:
        rng = np.random.default_rng([seed, *b"recognition"])
        way = way_over(road_map, 60.0, rng)
        ahead = way[12] - way[10]
        pose = Pose2(float(way[10][0]), float(way[10][1]), math.atan2(ahead[1], ahead[0]))
        people = _people(pose, rng)
        around = CameraSurroundings(dresser.of(people), scenes.of(people.selected(~people.people)))
        z_m = float(scene.ground.height_m(way[10][:1], way[10][1:2])[0]) + 6.0
        at = optical_pose(pose.x_m, pose.y_m, z_m, pose.yaw_rad, 0.25)
        mount = CameraMount("mast", at, 480, 360, math.radians(45.0))
        shot = SceneCamera(mount, scene, seed, light).take(np.eye(4), 0, around)
        small = _shrunk(shot.picture.pixels, shrink)
        feet, heights = _true_regions(mount, around.people.boxes_map)
        for k in range(len(heights)):
            apart = np.abs(feet[:, 0] - feet[k, 0])
            apart[k] = np.inf
            is_alone = apart.min() > 0.6 * heights[k] and shot.hidden[k] < 0.1
            if is_alone and HEIGHT_PX[0] <= heights[k] <= HEIGHT_PX[1] and 15 < feet[k, 0] < 465:
                at_px = (float(feet[k, 0]) * shrink, float(feet[k, 1]) * shrink)
                height_px = float(heights[k]) * shrink
                found.append((height_px, _best(detector, small, at_px, height_px)))
    return found


def recognition_row(case: str, shrink: float, scores: Scores) -> Row:
    """One row: how many of these people the detector's plane separates."""
    table = np.array(scores).reshape(-1, 2)
    return {
        "part": "recognition",
        "case": case,
        "people": len(table),
        "height_px": float(table[:, 0].mean()) if len(table) else math.nan,
        "recognised_pct": 100.0 * float((table[:, 1] > 0.0).mean()) if len(table) else math.nan,
        "score_median": float(np.median(table[:, 1])) if len(table) else math.nan,
        "shrunk_to": shrink,
    }


def _best(
    detector: HogPeopleDetector, pixels: np.ndarray, feet: tuple[float, float], height_px: float
) -> float:
    return max(detector.score(pixels, feet, height_px * size) for size in _SIZES)


def _shrunk(pixels: np.ndarray, shrink: float) -> np.ndarray:
    if shrink == 1.0:
        return pixels
    return cv2.resize(pixels, None, fx=shrink, fy=shrink, interpolation=cv2.INTER_AREA)


def _people(pose: Pose2, rng: np.random.Generator) -> Bodies:
    ranges, angles = rng.uniform(14.0, 23.0, _PEOPLE), pose.yaw_rad + rng.uniform(-0.34, 0.34, _PEOPLE)
    yaws = rng.uniform(-math.pi, math.pi, _PEOPLE)
    places = np.column_stack((pose.x_m + ranges * np.cos(angles), pose.y_m + ranges * np.sin(angles), yaws))
    return Bodies(
        rng.integers(1, 100_000, _PEOPLE), np.full(_PEOPLE, PEDESTRIAN, np.int64), places,
        1.2 * np.column_stack((np.cos(yaws), np.sin(yaws))), np.full((_PEOPLE, 2), 0.5),
    )  # fmt: skip


def _true_regions(mount: CameraMount, boxes_map: Array) -> tuple[Array, Array]:
    """Feet (k, 2) and heights (k,) in pixels."""
    T_camera_map = np.linalg.inv(mount.T_base_camera)
    low = np.column_stack((boxes_map[:, :3], np.ones(len(boxes_map)))) @ T_camera_map.T
    high = low + boxes_map[:, 3:] * T_camera_map[:, 2]
    feet, heads = low[:, :3] @ mount.K.T, high[:, :3] @ mount.K.T
    feet_px = feet[:, :2] / feet[:, 2:]
    return feet_px, feet_px[:, 1] - heads[:, 1] / heads[:, 2]
