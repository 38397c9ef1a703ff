"""Everything that stands beside the roads: trees, posts, signs, hedges, parked vehicles, works."""

import numpy as np
from numpy.typing import NDArray

from contract.geometry import Array
from contract.roads.model import RoadMap
from simulator.sensors.scene import shapes
from simulator.sensors.scene.changes import WorldChanges
from simulator.sensors.scene.ground import Ground
from simulator.sensors.scene.mesh import PackedMesh
from simulator.sensors.scene.placement import Footprint, RoadSide
from simulator.sensors.scene.sign_boards import sign_on_post, sign_poses

_BAY = Footprint(1.25, 2.7, 1.05)
_TRUCK_BAY = Footprint(1.5, 4.0, 1.3)
_CAR_M, _TRUCK_M = np.array([4.4, 1.8, 1.48]), np.array([7.0, 2.3, 3.1])
_POST = Footprint(0.6, 0.15, 0.15)
_SIGN = Footprint(0.7, 0.1, 0.35)
_TREE = Footprint(1.6, 0.3, 0.3)
_FAR_TREE = Footprint(6.0, 0.4, 0.4)
_HEDGE = Footprint(2.6, 1.0, 0.4)
_WORKS = Footprint(2.2, 4.2, 1.6)
# In front of a sign nothing stands that would hide it.
_SIGN_VIEW = Footprint(0.0, 4.0, 0.6)


class Furniture:
    """Collects the placed things of one scene.

    sway_phases  (objects,) of each object in the wind; the objects' numbers are those of `PackedMesh`
    parked       (k, 6) x, y, yaw, length, width, height of the parked cars and trucks
    """

    def __init__(self, ground: Ground, road_map: RoadMap, seed: int, changes: WorldChanges) -> None:
        """road_map: its buildings count, so that what the world's lost or gained moves nothing else."""
        self._ground, self._seed = ground, seed
        self.parts: list[PackedMesh] = []
        self.objects = 0
        roadside = RoadSide(ground, road_map.buildings)
        self._road_signs(road_map, roadside)
        rng = self._rng("places")
        # Building sites and parking places keep their ground free, whether they are taken or not.
        sites = roadside.place(roadside.every(45.0, rng), _WORKS, straight=True)
        bays = roadside.place(roadside.every(7.0, rng, 0.4), _BAY, straight=True)
        truck_bays = roadside.place(roadside.every(60.0, rng, 0.5), _TRUCK_BAY, straight=True)
        self._posts(roadside)
        self._trees(roadside, changes)
        self._works(sites, changes)
        self._parked(bays, truck_bays, changes)
        self.sway_phases: NDArray[np.float32] = (
            self._rng("sway").uniform(0.0, 2.0 * np.pi, max(1, self.objects)).astype(np.float32)
        )

    def _rng(self, name: str) -> np.random.Generator:
        return np.random.default_rng([self._seed, *name.encode()])

    def _road_signs(self, road_map: RoadMap, roadside: RoadSide) -> None:
        """The map's signs come first: what else stands beside the road leaves them free."""
        poses = sign_poses(road_map, self._ground)
        roadside.take(poses, _SIGN_VIEW)
        rng = self._rng("road signs")
        for kind in ("stop", "yield"):
            chosen = [sign.kind == kind for sign in road_map.signs]
            self._add(sign_on_post(kind), poses[np.array(chosen, dtype=np.bool_)], rng, 0.0)

    def _posts(self, roadside: RoadSide) -> None:
        rng = self._rng("posts")
        self._add(shapes.lamp_post(), roadside.place(roadside.every(28.0, rng), _POST), rng, 0.0)
        self._add(shapes.traffic_sign(), roadside.place(roadside.every(70.0, rng), _SIGN), rng, 0.0)
        self._add(shapes.bollard(), roadside.place(roadside.every(35.0, rng, 0.5), _POST), rng, 0.0)

    def _trees(self, roadside: RoadSide, changes: WorldChanges) -> None:
        rng = self._rng("trees")
        felled = np.random.default_rng([changes.seed, *b"felled"])
        kinds = shapes.trees(self._seed)
        poses = np.vstack(
            (
                roadside.place(roadside.every(9.0, rng, 0.55), _TREE),
                roadside.place(roadside.every(14.0, rng, 0.5), _FAR_TREE),
            )
        )
        chosen = rng.integers(0, len(kinds), len(poses))
        chosen[felled.random(len(poses)) < changes.trees_felled_ratio] = -1
        for kind, template in enumerate(kinds):
            self._add(template, poses[chosen == kind], rng, 0.15, turned=True)
        self._add(shapes.hedge(rng), roadside.place(roadside.every(2.1, rng, 0.08), _HEDGE), rng, 0.05)

    def _works(self, sites: Array, changes: WorldChanges) -> None:
        rng = np.random.default_rng([changes.seed, *b"works"])
        self._add(shapes.works(), rng.permutation(sites)[: changes.works], rng, 0.0)

    def _parked(self, bays: Array, truck_bays: Array, changes: WorldChanges) -> None:
        rng = np.random.default_rng([changes.seed, *b"parked"])
        is_taken = rng.random(len(bays)) < changes.parked_ratio
        poses = bays + rng.normal(0.0, 1.0, bays.shape) * np.array([0.15, 0.05, 0.02])
        # Some stand the other way round.
        poses[rng.random(len(bays)) < 0.3, 2] += np.pi
        cars = self._add(shapes.car(), poses[is_taken], rng, 0.08)
        is_truck = rng.random(len(truck_bays)) < min(1.0, 4.0 * changes.trucks_ratio * changes.parked_ratio)
        trucks = self._add(shapes.truck(), truck_bays[is_truck], rng, 0.08)
        self.parked: Array = np.vstack(
            (
                np.hstack((poses[is_taken], cars * _CAR_M)),
                np.hstack((truck_bays[is_truck], trucks * _TRUCK_M)),
            )
        )

    def _add(
        self,
        template: PackedMesh,
        poses: Array,
        rng: np.random.Generator,
        spread: float,
        turned: bool = False,
    ) -> Array:
        """(k, 3) scales of the copies at poses (k, 3), each of its own size and shade."""
        k = len(poses)
        if not k:
            return np.empty((0, 3))
        z = self._ground.pavement_m(poses[:, 0], poses[:, 1])
        yaw = rng.uniform(0.0, 2.0 * np.pi, k) if turned else poses[:, 2]
        scales = 1.0 + rng.uniform(-spread, spread, (k, 3)) if spread else np.ones((k, 3))
        shades = rng.uniform(0.6, 1.4, k) if spread else None
        placed = np.column_stack((poses[:, :2], z, yaw))
        self.parts.append(template.placed(placed, scales, shades, self.objects + np.arange(k)))
        self.objects += k
        return scales
