"""One camera in the scene: what it shows from a pose, and what stands before it."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from contract.geometry import Array
from simulator.sensors.cameras.clothed_people import ClothedPeople
from simulator.sensors.cameras.colours import triangle_colours
from simulator.sensors.cameras.exposure import developed
from simulator.sensors.cameras.light import DAY, Light
from simulator.sensors.cameras.mounts import CameraMount
from simulator.sensors.cameras.shading import LIGHT_COLUMNS, shade
from simulator.sensors.scene.static_scene import Array32, CastScene, RayTarget, StaticScene
from vehicle_agent.signals.pictures import Picture, PinholeCamera

_REACH_M = 300.0
# Rays of one pixel, where people are: a limb is a pixel or two wide.
_SUBSAMPLES = ((-0.25, -0.25), (0.25, -0.25), (-0.25, 0.25), (0.25, 0.25))
_OFF_SURFACE_M = 0.01
# Of a glimpse: the pixels that are always there, and what lens and sharpening reach beyond a window.
_COARSE, _EDGES_PX = 8, np.array([-4, -4, 4, 4])
# Rays that tell how much of a person is hidden.
_RAYS_ACROSS, _RAYS_DOWN = 12, 28


@dataclass(frozen=True, slots=True, eq=False)
class Shot:
    """A picture, and for scores which people it shows.

    numbers (k,) of the people; hidden (k,) share of each that something else hides, 1 outside the picture
    """

    picture: Picture
    numbers: NDArray[np.int64]
    hidden: Array


@dataclass(frozen=True, slots=True, eq=False)
class CameraSurroundings:
    """What moves around a camera at one moment: people, and the scene of everything on wheels."""

    people: ClothedPeople
    vehicles: RayTarget


class SceneCamera:
    """Takes pictures of a scene. The same seed, pose, stamp and surroundings give the same bytes."""

    def __init__(self, mount: CameraMount, scene: StaticScene, seed: int, light: Light = DAY) -> None:
        self.mount, self.light = mount, light
        self.model = PinholeCamera(mount.name, mount.K, mount.T_base_camera, mount.width_px, mount.height_px)
        self._scene, self._seed = scene, seed
        self._colours = _colours_of(scene)
        v, u = np.mgrid[: mount.height_px, : mount.width_px]
        self._pixels = np.column_stack((u.ravel(), v.ravel())).astype(np.float64)

    def take(self, T_map_base: Array, stamp_ns: int, around: CameraSurroundings) -> Shot:
        """The picture from a pose (4, 4) of the base; a fixed camera's base is the map (`np.eye(4)`)."""
        T_map_camera = np.asarray(T_map_base) @ self.mount.T_base_camera
        boxes = _boxes_px(self.mount, T_map_camera, around.people)
        everything = np.ones((self.mount.height_px, self.mount.width_px), dtype=bool)
        picture = self._picture(T_map_camera, stamp_ns, around, boxes, everything)
        hidden = self._hidden(T_map_camera, around, boxes)
        return Shot(picture, np.asarray(around.people.numbers), hidden)

    def glimpse(
        self, T_map_base: Array, stamp_ns: int, around: CameraSurroundings, windows: NDArray[np.int64]
    ) -> Picture:
        """A picture that is right in the windows (k, 4: left, top, right, bottom), and coarse elsewhere.

        For detectors that look at regions. Elsewhere one pixel of 8 x 8 stands for all.
        """
        T_map_camera = np.asarray(T_map_base) @ self.mount.T_base_camera
        wanted = np.zeros((self.mount.height_px, self.mount.width_px), dtype=bool)
        for left, top, right, bottom in np.maximum(windows + _EDGES_PX, 0):
            wanted[top:bottom, left:right] = True
        wanted[::_COARSE, ::_COARSE] = True
        boxes = _boxes_px(self.mount, T_map_camera, around.people)
        return self._picture(T_map_camera, stamp_ns, around, boxes, wanted)

    def _picture(
        self,
        T_map_camera: Array,
        stamp_ns: int,
        around: CameraSurroundings,
        boxes: NDArray[np.int64],
        wanted: NDArray[np.bool_],
    ) -> Picture:
        """Of the pixels `wanted` (h, w); others repeat the coarse one above and left of them."""
        mount = self.mount
        marked = np.zeros((mount.height_px, mount.width_px), dtype=bool)
        for left, top, right, bottom in boxes:
            marked[top:bottom, left:right] = True
        light = np.empty((marked.size, 3), dtype=np.float32)
        plain, fine = np.flatnonzero(wanted & ~marked), np.flatnonzero(wanted & marked)
        light[plain] = self._light_of(T_map_camera, self._pixels[plain], around)
        if len(fine):
            parts = [
                self._light_of(T_map_camera, self._pixels[fine] + offset, around) for offset in _SUBSAMPLES
            ]
            light[fine] = sum(parts) / len(parts)
        shown = light.reshape(*marked.shape, 3)
        if not wanted.all():
            blocks = shown[::_COARSE, ::_COARSE].repeat(_COARSE, axis=0).repeat(_COARSE, axis=1)
            shown = np.where(wanted[..., None], shown, blocks[: mount.height_px, : mount.width_px])
        rng = np.random.default_rng([self._seed, *mount.name.encode(), stamp_ns])
        sun_px, angle_rad = self._sun(T_map_camera, around)
        return Picture(mount.name, stamp_ns, developed(shown, self.light, sun_px, angle_rad, rng))

    def _light_of(self, T_map_camera: Array, places_px: Array, around: CameraSurroundings) -> Array32:
        """(n, 3) light of the rays through places (n, 2) of the picture."""
        rays = self._rays(T_map_camera, places_px)
        n = len(rays)
        origin = T_map_camera[:3, 3].astype(np.float32)
        origins = np.broadcast_to(origin, (n, 3)).astype(np.float32)
        hit_m, triangles = self._scene.cast(origins, rays, np.full(n, _REACH_M, dtype=np.float32))
        scenes: list[tuple[RayTarget, Array32]] = [
            (self._scene, self._colours),
            (around.vehicles, _colours_of(around.vehicles)),
            (around.people.scene, around.people.colours),
        ]
        owner = np.zeros(n, dtype=np.int8)
        for number, (scene, _) in enumerate(scenes[1:], 1):
            near_m, found = scene.cast(origins, rays, hit_m.copy())
            is_nearer = found >= 0
            owner[is_nearer], hit_m = number, np.where(is_nearer, near_m, hit_m)
            triangles = np.where(is_nearer, found, triangles)
        lit = self._sunlit(origins, rays, hit_m, triangles, owner, scenes, around)
        lights = self._light_row(T_map_camera)
        out = np.zeros((n, 3), dtype=np.float32)
        for number, (scene, colours) in enumerate(scenes):
            rows = np.flatnonzero(owner == number)
            if len(rows):
                surfaces = scene.surfaces
                shade(
                    rows, hit_m, triangles, origin, rays, lit, surfaces.normals, surfaces.materials, colours,
                    lights, out,
                )  # fmt: skip
        return out

    def _sunlit(
        self,
        origins: Array32,
        rays: Array32,
        hit_m: Array32,
        triangles: NDArray[np.int32],
        owner: NDArray[np.int8],
        scenes: list[tuple[RayTarget, Array32]],
        around: CameraSurroundings,
    ) -> NDArray[np.bool_]:
        """(n,) which of the surfaces the sun reaches."""
        lit = np.zeros(len(rays), dtype=bool)
        if not self.light.has_sun:
            return lit
        rows = np.flatnonzero(triangles >= 0)
        normals = np.empty((len(rows), 3), dtype=np.float32)
        for number, (scene, _) in enumerate(scenes):
            mine = owner[rows] == number
            normals[mine] = scene.surfaces.normals[triangles[rows[mine]]]
        normals *= -np.sign((normals * rays[rows]).sum(axis=1))[:, None]
        to_sun = self.light.to_sun.astype(np.float32)
        faces = normals @ to_sun > 0.0
        rows, normals = rows[faces], normals[faces]
        places = origins[rows] + hit_m[rows, None] * rays[rows] + _OFF_SURFACE_M * normals
        towards = np.broadcast_to(to_sun, (len(rows), 3)).astype(np.float32)
        free = np.ones(len(rows), dtype=bool)
        for scene in (self._scene, around.vehicles, around.people.scene):
            left = np.flatnonzero(free)
            far = np.full(len(left), _REACH_M, dtype=np.float32)
            _, blocked = scene.cast(places[left], towards[left], far)
            free[left] = blocked < 0
        lit[rows] = free
        return lit

    def _rays(self, T_map_camera: Array, places_px: Array) -> Array32:
        K = self.mount.K
        x = (places_px[:, 0] - K[0, 2]) / K[0, 0]
        y = (places_px[:, 1] - K[1, 2]) / K[1, 1]
        rays = np.column_stack((x, y, np.ones(len(x))))
        rays /= np.linalg.norm(rays, axis=1)[:, None]
        return np.ascontiguousarray(rays @ T_map_camera[:3, :3].T, dtype=np.float32)

    def _hidden(self, T_map_camera: Array, around: CameraSurroundings, boxes: NDArray[np.int64]) -> Array:
        """(k,) share of each person that something nearer hides, by rays through the person's box."""
        people = around.people
        hidden = np.ones(len(people.numbers))
        for k, number in enumerate(people.numbers.tolist()):
            left, top, right, bottom = boxes[k]
            if right <= left or bottom <= top:
                continue
            v, u = np.meshgrid(
                np.linspace(top, bottom - 1, _RAYS_DOWN),
                np.linspace(left, right - 1, _RAYS_ACROSS),
                indexing="ij",
            )
            rays = self._rays(T_map_camera, np.column_stack((u.ravel(), v.ravel())))
            origins = np.broadcast_to(T_map_camera[:3, 3], (len(rays), 3)).astype(np.float32)
            mine = people.scene.surfaces.objects == number
            alone_m, met = CastScene(people.mesh.selected(mine)).cast(
                origins, rays, np.full(len(rays), _REACH_M, dtype=np.float32)
            )
            rows = np.flatnonzero(met >= 0)
            if not len(rows):
                continue
            before_m = alone_m[rows] - np.float32(0.05)
            free = np.ones(len(rows), dtype=bool)
            for scene in (self._scene, around.vehicles, people.scene):
                _, blocked = scene.cast(origins[rows], rays[rows], before_m.copy())
                free &= (blocked < 0) if scene is not people.scene else ~_is_other(people, blocked, number)
            hidden[k] = 1.0 - float(free.mean())
        return hidden

    def _light_row(self, T_map_camera: Array) -> Array32:
        light = self.light
        row = np.zeros(LIGHT_COLUMNS, dtype=np.float32)
        row[:3], row[3] = light.to_sun, light.sun if light.has_sun else 0.0
        row[4], row[5], row[6:9] = light.sky, light.headlights, T_map_camera[:3, 2]
        row[9] = 1.0 / self.mount.K[0, 0]
        row[10] = 4000.0 / light.rain_mm_per_h if light.rain_mm_per_h > 0.0 else 0.0
        return row

    def _sun(
        self, T_map_camera: Array, around: CameraSurroundings
    ) -> tuple[tuple[float, float] | None, float]:
        """Where the sun stands in the picture, if the camera sees it, and its angle to the axis."""
        to_sun = self.light.to_sun
        ahead = T_map_camera[:3, :3].T @ to_sun
        angle_rad = math.acos(float(np.clip(ahead[2], -1.0, 1.0)))
        if not self.light.has_sun or ahead[2] <= 0.05:
            return None, angle_rad
        origin = T_map_camera[None, :3, 3].astype(np.float32)
        ray, far = to_sun[None].astype(np.float32), np.full(1, _REACH_M, dtype=np.float32)
        if any(scene.cast(origin, ray, far.copy())[1][0] >= 0 for scene in (self._scene, around.vehicles)):
            return None, angle_rad
        u, v, _ = self.mount.K @ (ahead / ahead[2])
        return (float(u), float(v)), angle_rad


def _is_other(people: ClothedPeople, triangles: NDArray[np.int32], number: int) -> NDArray[np.bool_]:
    """(n,) which triangles belong to another person; -1 to none."""
    other: NDArray[np.bool_] = people.scene.surfaces.objects[np.maximum(triangles, 0)] != number
    return other & (triangles >= 0)


def _boxes_px(mount: CameraMount, T_map_camera: Array, people: ClothedPeople) -> NDArray[np.int64]:
    """(k, 4) left, top, right, bottom of each person, clipped to the picture; empty behind the camera."""
    K, T_camera_map = mount.K, np.linalg.inv(T_map_camera)
    boxes = np.zeros((len(people.boxes_map), 4), dtype=np.int64)
    for k, (x, y, z, height_m) in enumerate(people.boxes_map):
        corners = np.array(
            [
                (x + dx, y + dy, z + up, 1.0)
                for dx in (-0.6, 0.6) for dy in (-0.6, 0.6) for up in (-0.1, height_m + 0.1)
            ]
        )  # fmt: skip
        seen = (T_camera_map @ corners.T)[:3]
        if seen[2].max() < 0.2:
            continue
        depth = np.maximum(seen[2], 0.2)
        u, v = K[0, 0] * seen[0] / depth + K[0, 2], K[1, 1] * seen[1] / depth + K[1, 2]
        edges = np.array([u.min() - 1, v.min() - 1, u.max() + 2, v.max() + 2])
        boxes[k] = np.clip(edges, 0, (mount.width_px, mount.height_px, mount.width_px, mount.height_px))
    return boxes


_COLOURS_OF_NONE: Array32 = np.empty((0, 3), dtype=np.float32)


def _colours_of(scene: RayTarget) -> Array32:
    return triangle_colours(scene.surfaces) if len(scene.triangles) else _COLOURS_OF_NONE
