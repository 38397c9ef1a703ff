"""The Snow Lion stack's world: the GEM stack's, with predictions, the view, areas and occupied stops."""

import math

import msgspec
import numpy as np
from numba import njit

from contract.geometry import Array, Pose2, inverse, transform_points
from contract.roads.network import RoadNetwork
from contract.roads.walls import wall_edges
from vehicle_agent.signals import (
    NO_PREDICTIONS,
    NO_VIEW,
    VEHICLE,
    Detections,
    Ego,
    FleetVehicle,
    Infrastructure,
    Predictions,
    Tracks,
    View,
    WatchedArea,
    World,
)
from vehicle_agent.world.area_monitor import AreaMonitor, outlines_of, with_people
from vehicle_agent.world.camera_trust import CameraTrust, TrustRules
from vehicle_agent.world.prediction import Predictor
from vehicle_agent.world.surroundings import Surroundings, SurroundingsState
from vehicle_agent.world.view import VisibilityParams, points_on_walls

# Fleet vehicles that no sensor detects become tracks; their ids count down from here.
FLEET_TRACK_ID_FROM = -1
_SAME_VEHICLE_M = 2.5
_STANDING_MPS = 0.5
# A vehicle whose centre is farther from a stop cannot stand on it.
_STOP_NEAR_M = 15.0


class ObservedWorldState(msgspec.Struct, frozen=True):
    """What the world remembers: the surroundings, and what was computed from the last scan."""

    surroundings: SurroundingsState
    computed_ns: int = 0
    points_map: np.ndarray = msgspec.field(default_factory=lambda: np.empty((0, 2)))
    tracks: Tracks | None = None
    predictions: Predictions = NO_PREDICTIONS
    view: View = NO_VIEW
    occupied_stops: tuple[str, ...] = ()
    watched: tuple[WatchedArea, ...] = ()
    cameras: tuple[CameraTrust, ...] = ()


class ObservedWorld:
    """Built once for a map.

    track_margin_m  cells this near to a track's outline belong to the track
    walls_from_map  a vehicle without lidar takes the walls near it from the map
    """

    def __init__(
        self,
        network: RoadNetwork,
        surroundings: Surroundings,
        visibility: VisibilityParams,
        predictor: Predictor | None = None,
        track_margin_m: float = 0.35,
        area_monitor: AreaMonitor | None = None,
        walls_from_map: bool = False,
        trust_rules: TrustRules = TrustRules(),
    ) -> None:
        self._network = network
        self._surroundings = surroundings
        self._visibility = visibility
        self._predictor = predictor or Predictor()
        self._track_margin_m = track_margin_m
        self._area_monitor = area_monitor or AreaMonitor()
        self._areas = network.road_map.observation_areas
        self._outlines = outlines_of(self._areas)
        self._walls_from_map = walls_from_map
        self._trust_rules = trust_rules
        self._edges = wall_edges(network.road_map.buildings)
        stops = [network.pose(stop.lane_id, stop.s_m) for stop in network.road_map.stops]
        self._stop_ids = tuple(stop.stop_id for stop in network.road_map.stops)
        self._stop_poses: Array = np.array(stops).reshape(-1, 3)

    def initial(self) -> ObservedWorldState:
        return ObservedWorldState(self._surroundings.initial())

    def step(
        self,
        state: ObservedWorldState,
        ego: Ego,
        detections: Detections,
        infrastructure: tuple[Infrastructure, ...],
        now_ns: int,
    ) -> tuple[World, ObservedWorldState]:
        """The world now. Predictions are made once a scan; fleet vehicles are extrapolated to now_ns."""
        basic, surroundings = self._surroundings.step(
            state.surroundings, ego, detections, infrastructure, now_ns
        )
        state = msgspec.structs.replace(state, surroundings=surroundings)
        newest_ns = max(detections.stamp_ns, detections.tracks.stamp_ns)
        if state.tracks is None or newest_ns != state.computed_ns:
            state = self._computed(state, ego, detections, basic, newest_ns)
        assert state.tracks is not None
        world = msgspec.structs.replace(
            basic,
            points_map=state.points_map,
            tracks=state.tracks,
            predictions=state.predictions,
            view=state.view,
            occupied_stops=state.occupied_stops,
            watched=state.watched,
        )
        return world, state

    def _computed(
        self, state: ObservedWorldState, ego: Ego, detections: Detections, basic: World, newest_ns: int
    ) -> ObservedWorldState:
        tracks = _with_fleet_vehicles(detections.tracks, basic.fleet_vehicles, self._surroundings)
        obstacles = basic.points_map
        if self._walls_from_map:
            obstacles = np.vstack(
                (obstacles, points_on_walls(self._edges, ego.pose_map, self._visibility.range_m))
            )
        points = without_tracks(
            obstacles,
            tracks.poses_map,
            tracks.sizes_m,
            self._track_margin_m,
            tracks.velocities_map_mps,
        )
        predictions = self._predictor.predictions(tracks, self._network)
        reporting = frozenset(report.area_id for report in basic.presence)
        tracked_in = with_people(self._areas, self._outlines, reporting, tracks) if reporting else reporting
        cameras = self._trust_rules.update(state.cameras, basic.presence, tracked_in)
        clear_ns = {trust.area_id: self._trust_rules.clear_ns(trust, basic.stamp_ns) for trust in cameras}
        return msgspec.structs.replace(
            state,
            computed_ns=newest_ns,
            points_map=points,
            tracks=tracks,
            predictions=predictions,
            watched=self._area_monitor.watched(
                self._areas, self._outlines, ego.pose_map, tracks, predictions, basic.presence, clear_ns
            ),
            cameras=cameras,
            view=self._visibility.view(ego.pose_map, points, tracks, self._edges),
            occupied_stops=self._occupied_stops(tracks, ego.pose_map),
        )

    def _occupied_stops(self, tracks: Tracks, pose_map: Pose2) -> tuple[str, ...]:
        """Ids of the stops in range where another vehicle stands in this vehicle's outline at the stop."""
        standing = (tracks.kinds == VEHICLE) & (
            np.abs(tracks.velocities_map_mps).max(axis=1, initial=0.0) < _STANDING_MPS
        )
        poses, sizes = tracks.poses_map[standing], tracks.sizes_m[standing]
        occupied = []
        for stop_id, (x_m, y_m, yaw_rad) in zip(self._stop_ids, self._stop_poses, strict=True):
            if math.hypot(x_m - pose_map.x_m, y_m - pose_map.y_m) > self._visibility.range_m:
                continue
            near = np.hypot(poses[:, 0] - x_m, poses[:, 1] - y_m) < _STOP_NEAR_M
            docked = Pose2(float(x_m), float(y_m), float(yaw_rad))
            if any(self._is_on_stop(docked, *row) for row in zip(poses[near], sizes[near], strict=True)):
                occupied.append(stop_id)
        return tuple(occupied)

    def _is_on_stop(self, docked: Pose2, pose: Array, size: Array) -> bool:
        """True if a point of the other outline, every 0.5 m or closer, lies in this vehicle's, docked."""
        along = np.linspace(-0.5, 0.5, 2 + int(size[0] / 0.5)) * size[0]
        across = np.linspace(-0.5, 0.5, 2 + int(size[1] / 0.5)) * size[1]
        grid = np.column_stack([axis.ravel() for axis in np.meshgrid(along, across)])
        outline = transform_points(Pose2(float(pose[0]), float(pose[1]), float(pose[2])), grid)
        points_docked = transform_points(inverse(docked), outline)
        body = self._surroundings
        inside = (points_docked[:, 0] >= -body.body_back_m) & (points_docked[:, 0] <= body.body_front_m)
        return bool((inside & (np.abs(points_docked[:, 1]) <= body.body_half_width_m)).any())


def _with_fleet_vehicles(
    tracks: Tracks, fleet_vehicles: tuple[FleetVehicle, ...], body: Surroundings
) -> Tracks:
    """The tracks, and the fleet vehicles that none of them represents."""
    length_m, width_m = body.body_front_m + body.body_back_m, 2.0 * body.body_half_width_m
    forward_m = 0.5 * (body.body_front_m - body.body_back_m)
    rows = []
    for number, vehicle in enumerate(fleet_vehicles):
        pose, speed = vehicle.pose_map, vehicle.speed_mps
        cos, sin = math.cos(pose.yaw_rad), math.sin(pose.yaw_rad)
        x_m, y_m = pose.x_m + forward_m * cos, pose.y_m + forward_m * sin
        distances_m = np.hypot(tracks.poses_map[:, 0] - x_m, tracks.poses_map[:, 1] - y_m)
        if len(distances_m) and distances_m.min() < _SAME_VEHICLE_M:
            continue
        rows.append((FLEET_TRACK_ID_FROM - number, x_m, y_m, pose.yaw_rad, speed * cos, speed * sin))
    if not rows:
        return tracks
    table = np.array(rows)
    return Tracks(
        tracks.stamp_ns,
        np.concatenate((tracks.ids, table[:, 0].astype(np.int64))),
        np.concatenate((tracks.kinds, np.full(len(rows), VEHICLE, np.int64))),
        np.vstack((tracks.poses_map, table[:, 1:4])),
        np.vstack((tracks.velocities_map_mps, table[:, 4:6])),
        np.vstack((tracks.sizes_m, np.full((len(rows), 2), (length_m, width_m)))),
    )


@njit(cache=True)
def without_tracks(points: Array, poses: Array, sizes: Array, margin_m: float, velocities: Array) -> Array:
    """(m, 2) the points (n, 2) outside every track's outline and its margin.

    poses (k, 3) of the centres, sizes (k, 2), velocities (k, 2). The margin of a moving track is longer along
    its way, since scan and track are not from the same moment.
    """
    keep = np.ones(points.shape[0], np.bool_)
    for k in range(poses.shape[0]):
        cos, sin = math.cos(poses[k, 2]), math.sin(poses[k, 2])
        lag = 0.15 * math.hypot(velocities[k, 0], velocities[k, 1])
        length, width = 0.5 * sizes[k, 0] + margin_m + lag, 0.5 * sizes[k, 1] + margin_m
        for i in range(points.shape[0]):
            dx, dy = points[i, 0] - poses[k, 0], points[i, 1] - poses[k, 1]
            if abs(cos * dx + sin * dy) <= length and abs(-sin * dx + cos * dy) <= width:
                keep[i] = False
    return points[keep]
