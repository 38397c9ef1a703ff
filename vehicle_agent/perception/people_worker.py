"""The perception worker of a vehicle with a planar scanner and a camera for people, as the NUS paper's."""

import msgspec
import numpy as np

from contract.geometry import Array, IntArray, Pose2, inverse, transform_points
from vehicle_agent.perception.camera.people_detector import windows_px
from vehicle_agent.perception.laser_people.people import LaserPeople, LaserPeopleState, beams_of
from vehicle_agent.perception.laser_people.verification import RegionScorer
from vehicle_agent.perception.own_tracks import TracksWorker
from vehicle_agent.perception.points.chain import PointPerception
from vehicle_agent.perception.signs.boards import SignFinder
from vehicle_agent.perception.thinned_scans import ScanThinning
from vehicle_agent.signals import ObstaclePercept, Percept
from vehicle_agent.signals.objects import SeenObjects
from vehicle_agent.signals.pictures import Picture, PinholeCamera

# A laser that is silent for longer finds nothing any more.
_SILENT_NS = 300_000_000
# A camera without anything to look at is asked for a picture so often, to know that it is well.
_WELL_NS = 600_000_000
# Of the laser's returns so near, three in a cell are an obstacle: there the lidar on the roof sees little.
_NEAR_M, _RETURNS_MIN = 5.0, 3
_NO_WINDOWS: IntArray = np.empty((0, 4), np.int64)


class PeopleFinder:
    """People by one laser and one camera, in the frame that the worker reckons.

    state  what is known; condition of the camera included. height_m: of the laser over the ground
    """

    def __init__(
        self,
        room: LaserPeople,
        T_base_laser: Array,
        field_rad: float,
        step_rad: float,
        camera: PinholeCamera | None = None,
        scorer: RegionScorer | None = None,
    ) -> None:
        """field_rad, step_rad: of the scanner; camera or scorer None: people are told by the laser alone."""
        self._room, self._T_base_laser = room, T_base_laser
        self._field_rad, self._step_rad = field_rad, step_rad
        self._camera, self._scorer = camera, scorer
        self.height_m = float(T_base_laser[2, 3])
        self.state = LaserPeopleState()
        self._seen_ns = -_WELL_NS
        self._near_odom: Array = np.empty((0, 2))

    def take_scan(self, points_base: np.ndarray, stamp_ns: int, pose_odom: Pose2) -> None:
        """points_base (n, 3): of a planar scan, base frame at stamp_ns."""
        ranges, angles = beams_of(points_base, self._T_base_laser, self._field_rad, self._step_rad)
        near = np.hypot(*(points_base[:, :2] - self._T_base_laser[:2, 3]).T) <= _NEAR_M
        self._near_odom = transform_points(pose_odom, points_base[near, :2].astype(np.float64))
        self.state = self._room.after_scan(
            self.state, ranges, angles, self._T_base_laser, pose_odom, stamp_ns
        )

    def near_cells(self, stamp_ns: int, pose_odom: Pose2, cell_m: float) -> Array:
        """(k, 2) middles of the cells near the laser that its newest scan meets, base frame at stamp_ns."""
        if stamp_ns - self.state.tracks.stamp_ns > _SILENT_NS or not len(self._near_odom):
            return np.empty((0, 2))
        places = transform_points(inverse(pose_odom), self._near_odom)
        cells, counts = np.unique(np.floor(places / cell_m), axis=0, return_counts=True)
        met: Array = (cells[counts >= _RETURNS_MIN] + 0.5) * cell_m
        return met

    def windows(self, stamp_ns: int, pose_odom: Pose2) -> IntArray | None:
        """(k, 4) left, top, right, bottom of what `look` would read of a picture; None: it needs none now."""
        camera, tracks = self._camera, self.state.tracks
        if camera is None or self._scorer is None:
            return None
        feet_px, heights_px = self._room.verification.asked_regions(
            tracks, self._room.tracker.is_followed(tracks), stamp_ns, camera, pose_odom
        )
        if len(heights_px):
            return windows_px(feet_px, heights_px)
        return _NO_WINDOWS if stamp_ns - self._seen_ns >= _WELL_NS else None

    @property
    def looks_at_pictures(self) -> bool:
        """There is a camera, and what looks at its pictures."""
        return self._camera is not None and self._scorer is not None

    @property
    def picture_px(self) -> tuple[int, int]:
        """Rows and columns; (0, 0) without a camera."""
        return (0, 0) if self._camera is None else (self._camera.height_px, self._camera.width_px)

    def look(self, picture: Picture, pose_odom: Pose2) -> None:
        """pose_odom: of the vehicle when the picture was taken."""
        if self._camera is None or self._scorer is None:
            return
        self._seen_ns = picture.stamp_ns
        self.state = self._room.after_picture(self.state, picture, self._camera, pose_odom, self._scorer)

    def found(
        self, points: np.ndarray, intensities: np.ndarray, stamp_ns: int, pose_odom: Pose2
    ) -> SeenObjects | None:
        """People, and what moves, moved to stamp_ns by their velocities."""
        del points, intensities
        if abs(stamp_ns - self.state.tracks.stamp_ns) > _SILENT_NS:
            return None
        return self._room.seen_objects(self.state, pose_odom, stamp_ns)


class PeopleWorker(TracksWorker):
    """Cells and tracks of the lidar's points; people by the planar scanner, verified in pictures.

    Without planar scans or pictures it gives what the points alone show.
    """

    def __init__(
        self,
        perception: PointPerception,
        people: PeopleFinder,
        thinning: ScanThinning | None = None,
        sign_finder: SignFinder | None = None,
    ) -> None:
        super().__init__(perception, people, thinning, sign_finder)
        self.people, self._cell_m = people, perception.grid.cell_m

    def percepts(self, rows: np.ndarray, stamp_ns: int) -> tuple[Percept, ...]:
        """As of `TracksWorker`; the cells have what the planar scanner meets near the vehicle, too."""
        return tuple(
            self._with_near_cells(percept) if isinstance(percept, ObstaclePercept) else percept
            for percept in super().percepts(rows, stamp_ns)
        )

    def _with_near_cells(self, cells: ObstaclePercept) -> ObstaclePercept:
        pose_odom = self._way.pose_odom(cells.stamp_ns)
        near = self.people.near_cells(cells.stamp_ns, pose_odom, self._cell_m)
        is_low = cells.is_low
        if len(is_low) == len(cells.cells_base):
            is_low = np.concatenate((is_low, np.zeros(len(near), np.bool_)))
        return msgspec.structs.replace(
            cells,
            cells_base=np.vstack((cells.cells_base, near)),
            heights_m=np.concatenate((cells.heights_m, np.full(len(near), self.people.height_m))),
            is_low=is_low,
        )

    def planar(self, rows: np.ndarray, stamp_ns: int) -> None:
        """Take a scan of the planar scanner: rows (n, 5) as of `percepts`."""
        self.people.take_scan(self._straightened(rows), stamp_ns, self._way.pose_odom(stamp_ns))

    @property
    def looks_at_pictures(self) -> bool:
        return self.people.looks_at_pictures

    @property
    def picture_px(self) -> tuple[int, int]:
        """Rows and columns of the camera's pictures; those of another size show other places."""
        return self.people.picture_px

    def windows(self, stamp_ns: int) -> IntArray | None:
        """(k, 4) left, top, right, bottom: parts of a picture of stamp_ns that would be looked at.

        For cameras that can read out parts, and for simulations. None: no picture is needed now.
        """
        return self.people.windows(stamp_ns, self._way.pose_odom(stamp_ns))

    def look(self, picture: Picture) -> None:
        """Take a picture of the camera."""
        self.people.look(picture, self._way.pose_odom(picture.stamp_ns))
