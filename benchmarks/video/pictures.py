"""Pictures of a vehicle's four simulated cameras, and the process that plays them to the recorder."""

import os
import time
from multiprocessing.synchronize import Event
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.sensors.drive import Drive, way_over
from contract.roads.model import RoadMap
from simulator.sensors.cameras.camera import CameraSurroundings, SceneCamera
from simulator.sensors.cameras.clothed_people import PeopleDresser
from simulator.sensors.cameras.mounts import four_cameras
from simulator.sensors.scene.moving_scene import MovingScenes
from simulator.sensors.scene.static_scene import StaticScene
from simulator.traffic.actors import Bodies
from vehicle_agent.config import Body
from vehicle_agent.picture_ring import PictureRing
from vehicle_agent.signals import PEDESTRIAN

PERIOD_NS = 100_000_000
STOPPED_NS = 3_000_000_000
SPEED_MPS = 3.0
PEOPLE = 12
_FLEET_FROM = 1_000_000


def rendered(road_map: RoadMap, seed: int, count: int) -> dict[str, NDArray[np.uint8]]:
    """By camera, (count, h, w, 3): a drive at 3 m/s among people who walk, ten pictures a second."""
    rng = np.random.default_rng([seed, *b"video"])
    body, scene = Body(), StaticScene(road_map, seed)
    way = way_over(road_map, 20.0 + SPEED_MPS * 0.1 * count + 40.0, rng)
    drive = Drive(way, scene.ground, SPEED_MPS, body.wheelbase_m)
    cameras = [SceneCamera(mount, scene, seed) for mount in four_cameras(body)]
    dresser, scenes = PeopleDresser(scene.ground, seed), MovingScenes(scene.ground, _FLEET_FROM)
    stamps_ns = np.arange(1, count + 1, dtype=np.int64) * PERIOD_NS
    poses = drive.poses(stamps_ns)
    places = poses[0, :2, 3] + rng.uniform(-12.0, 12.0, (PEOPLE, 2))
    ways_mps = rng.uniform(-1.3, 1.3, (PEOPLE, 2))
    shots: dict[str, list[NDArray[np.uint8]]] = {camera.mount.name: [] for camera in cameras}
    for stamp_ns, pose in zip(stamps_ns, poses, strict=True):
        xy = places + ways_mps * (stamp_ns * 1e-9)
        yaws = np.arctan2(ways_mps[:, 1], ways_mps[:, 0])
        people = Bodies(
            np.arange(PEOPLE),
            np.full(PEOPLE, PEDESTRIAN),
            np.column_stack((xy, yaws)),
            ways_mps,
            np.full((PEOPLE, 2), 0.5),
        )
        around = CameraSurroundings(dresser.of(people), scenes.of(people.selected(~people.people)))
        for camera in cameras:
            shots[camera.mount.name].append(camera.take(pose, int(stamp_ns), around).picture.pixels)
    return {name: np.stack(pictures) for name, pictures in shots.items()}


def play(pictures: Path, rings: dict[str, Path], stamps: Path, stop: Event, seed: int) -> None:
    """Writes the pictures of a file, forth and back, into the rings, and at the end their stamps beside.

    Sensor noise is added to each picture, so that none is the one before it.
    """
    # On a vehicle a camera's driver is no competitor of the tick.
    os.nice(10)
    loaded = np.load(pictures)
    shots = {name: loaded[name] for name in rings}
    open_rings = {name: PictureRing(path, create=True) for name, path in rings.items()}
    rng = np.random.default_rng(seed)
    written: dict[str, list[int]] = {name: [] for name in rings}
    count = len(next(iter(shots.values())))
    order = [*range(count), *range(count - 2, 0, -1)]
    # Cameras of a vehicle do not expose at one moment, and the encoder need not take all at once.
    apart_ns = PERIOD_NS // len(rings)
    begun_ns, number = time.monotonic_ns(), 0
    while not stop.is_set():
        for place, (name, ring) in enumerate(open_rings.items()):
            due_ns = begun_ns + number * PERIOD_NS + place * apart_ns
            if time.monotonic_ns() - due_ns > STOPPED_NS:
                # It was stopped meanwhile: what was not taken is not played later.
                begun_ns += time.monotonic_ns() - due_ns
                due_ns = time.monotonic_ns()
            time.sleep(max(0.0, (due_ns - time.monotonic_ns()) / 1e9))
            picture = shots[name][order[number % len(order)]].copy()
            row = int(rng.integers(0, picture.shape[0] - 8)) & ~7
            picture[row : row + 8] ^= rng.integers(0, 4, picture[row : row + 8].shape, dtype=np.uint8)
            stamp_ns = time.monotonic_ns()
            ring.write(stamp_ns, picture)
            written[name].append(stamp_ns)
        number += 1
    np.savez(stamps, **{name: np.array(times) for name, times in written.items()})
