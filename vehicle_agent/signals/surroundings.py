"""perception, world: road users and obstacles around the vehicle."""

from typing import Literal

import msgspec
import numpy as np

from contract.geometry import Pose2
from contract.roads.model import Point
from vehicle_agent.signals.arriving import FleetVehicle, PedestrianPresence


class Tracks(msgspec.Struct, frozen=True):
    """Tracked road users, map frame; fields as in `TrackPercept`. stamp_ns 0 before the first."""

    stamp_ns: int
    ids: np.ndarray
    kinds: np.ndarray
    poses_map: np.ndarray
    velocities_map_mps: np.ndarray
    sizes_m: np.ndarray


NO_TRACKS = Tracks(
    0,
    np.empty(0, np.int64),
    np.empty(0, np.int64),
    np.empty((0, 3)),
    np.empty((0, 2)),
    np.empty((0, 2)),
)


class SeenSign(msgspec.Struct, frozen=True):
    """perception: a traffic sign ahead, as the lidars have seen it over some scans.

    sign_id   constant as long as the sign is known
    kind      "board": a sign's board whose shape is not known yet; "other": neither stop nor yield
    pose_map  middle of the board; the yaw is that of its normal, towards those for whom it stands
    range_m   at which it was seen last
    """

    sign_id: int
    kind: Literal["stop", "yield", "board", "other"]
    pose_map: Pose2
    range_m: float


class Detections(msgspec.Struct, frozen=True):
    """perception: obstacles around the vehicle; the same object until the next scan.

    points_map  (n, 2) obstacle cell centres, map frame
    is_low      (n,) bool: kerbs, beside which one may drive but not over them; empty: none is
    kerbs_map   (k, 2) kerbs of a finder that does not take them for obstacles
    stamp_ns    end of the scan they come from, 0 before the first
    signs       traffic signs ahead, of stacks that look for them
    """

    stamp_ns: int
    points_map: np.ndarray
    blind: bool
    tracks: Tracks = NO_TRACKS
    signs: tuple[SeenSign, ...] = ()
    is_low: np.ndarray = msgspec.field(default_factory=lambda: np.empty(0, np.bool_))
    kerbs_map: np.ndarray = msgspec.field(default_factory=lambda: np.empty((0, 2)))


class LeadVehicle(msgspec.Struct, frozen=True):
    """The fleet vehicle ahead on our path, and the gap between its rear and our front bumper."""

    vehicle_id: str
    gap_m: float
    speed_mps: float


class Predictions(msgspec.Struct, frozen=True):
    """Where each of the world's tracks is expected to be, in the order of the tracks.

    times_s     (k,) after stamp_ns, from 0 on
    poses_map   (n, k, 3) middle of the outline
    sigmas_m    (n, k) standard deviation of the place, in any direction
    """

    stamp_ns: int
    times_s: np.ndarray
    poses_map: np.ndarray
    sigmas_m: np.ndarray


NO_PREDICTIONS = Predictions(0, np.zeros(1), np.empty((0, 1, 3)), np.empty((0, 1)))


class View(msgspec.Struct, frozen=True):
    """How far the vehicle can see in each direction; a person may be anywhere beyond.

    pose_map   of the sensor
    ranges_m   (n,) free line of sight by bearing in the sensor's frame, from -pi in n equal steps
    """

    pose_map: Pose2
    ranges_m: np.ndarray


NO_VIEW = View(Pose2(0.0, 0.0, 0.0), np.empty(0))


class WatchedArea(msgspec.Struct, frozen=True):
    """Road users in, or about to enter, one of the map's observation areas.

    track_ids  of moving tracks whose predicted way crosses our lanes in the area
    reported   an infrastructure camera reports it occupied: a reason to slow
    clear_ns   stamp of the picture by which a camera that is believed saw nobody in `outline`, 0 without one
    """

    area_id: str
    track_ids: tuple[int, ...]
    reported: bool = False
    clear_ns: int = 0
    outline: tuple[Point, ...] = ()


class World(msgspec.Struct, frozen=True):
    """world: what the vehicle must respect, besides its own task.

    detections_stamp_ns  of the detections in use
    points_map      (n, 2) obstacle cells that belong neither to fleet vehicles nor to tracks
    is_low          (n,) bool: which of them are kerbs; empty: none is
    kerbs_map       (k, 2) kerbs of a finder that does not take them for obstacles
    fleet_vehicles  fleet vehicles reported lately, extrapolated to stamp_ns
    presence        the newest camera report of each area
    tracks          tracked road users; predictions in the same order
    watched         the observation areas near the vehicle
    occupied_stops  ids of stops on which another vehicle stands
    signs           traffic signs ahead, of stacks that look for them
    """

    stamp_ns: int
    detections_stamp_ns: int
    points_map: np.ndarray
    fleet_vehicles: tuple[FleetVehicle, ...]
    presence: tuple[PedestrianPresence, ...]
    blind: bool
    tracks: Tracks = NO_TRACKS
    predictions: Predictions = NO_PREDICTIONS
    view: View = NO_VIEW
    watched: tuple[WatchedArea, ...] = ()
    occupied_stops: tuple[str, ...] = ()
    signs: tuple[SeenSign, ...] = ()
    is_low: np.ndarray = msgspec.field(default_factory=lambda: np.empty(0, np.bool_))
    kerbs_map: np.ndarray = msgspec.field(default_factory=lambda: np.empty((0, 2)))
