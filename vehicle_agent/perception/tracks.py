"""Obstacle cells as in the GEM stack, and tracks of road users."""

import msgspec

from vehicle_agent.perception.cells import CellsState, HeightMapPerception
from vehicle_agent.perception.kerbs import KerbMemory, KerbsState
from vehicle_agent.perception.own_cells import outside_tracks
from vehicle_agent.perception.tracker import AlphaBetaTracker, TrackerState
from vehicle_agent.signals import (
    Detections,
    Ego,
    Fault,
    ObstaclePercept,
    PerceptionInput,
    TrackPercept,
)
from vehicle_agent.signals.pose_history import pose_at


class TracksState(msgspec.Struct, frozen=True):
    """The states of cells, tracker and kerbs, and the last detections."""

    cells_state: CellsState
    tracker_state: TrackerState
    detections: Detections
    kerbs: KerbsState = KerbsState()


class TrackingPerception(msgspec.Struct, frozen=True):
    """Cells and tracks together.

    has_lidar     False: tracks alone, as in a simulation without scans
    own_margin_m  cells this near to a track's outline belong to it; they are not remembered in the blind
                  zone, since the tracked person walks on and would leave a false obstacle
    """

    cells: HeightMapPerception
    tracker: AlphaBetaTracker = AlphaBetaTracker()
    has_lidar: bool = True
    own_margin_m: float = 0.5
    kerbs: KerbMemory = KerbMemory()

    def initial(self) -> TracksState:
        cells_state = self.cells.initial()
        return TracksState(cells_state, TrackerState(), cells_state.detections)

    def step(
        self, state: TracksState, percepts: tuple[PerceptionInput, ...], ego: Ego
    ) -> tuple[Detections, TracksState]:
        """The detections, with the stamp of the older source; the same object until either is newer."""
        cells, cells_state = self.cells.step(state.cells_state, percepts, ego)
        newer = [
            percept
            for percept in percepts
            if isinstance(percept, TrackPercept) and percept.stamp_ns > state.tracker_state.tracks.stamp_ns
        ]
        tracker_state = state.tracker_state
        for percept in sorted(newer, key=lambda item: item.stamp_ns):
            tracker_state = self.tracker.step(
                tracker_state, percept, pose_at(cells_state.poses, percept.stamp_ns)
            )
        if tracker_state is state.tracker_state and cells is state.cells_state.detections:
            return state.detections, msgspec.structs.replace(state, cells_state=cells_state)
        kerbs = state.kerbs
        if cells is not state.cells_state.detections:
            cells_state = self._without_tracked_cells(cells_state, tracker_state)
            kerbs = self._with_kerbs(kerbs, percepts, cells_state, cells.stamp_ns)
        stamp_ns = tracker_state.tracks.stamp_ns
        if self.has_lidar:
            stamp_ns = min(stamp_ns, cells.stamp_ns)
        detections = Detections(
            stamp_ns, cells.points_map, cells.blind and self.has_lidar, tracker_state.tracks,
            kerbs_map=self.kerbs.places_map(kerbs),
        )  # fmt: skip
        return detections, TracksState(cells_state, tracker_state, detections, kerbs)

    def _with_kerbs(
        self, kerbs: KerbsState, percepts: tuple[PerceptionInput, ...], cells_state: CellsState, stamp_ns: int
    ) -> KerbsState:
        """With those of the scan whose cells are in force."""
        for percept in percepts:
            if isinstance(percept, ObstaclePercept) and percept.stamp_ns == stamp_ns:
                pose_map = pose_at(cells_state.poses, stamp_ns)
                return self.kerbs.step(kerbs, percept.kerbs_base, pose_map, stamp_ns)
        return kerbs

    def faults(self, state: TracksState, now_ns: int) -> tuple[Fault, ...]:
        """What is wrong with single lidars, as their driver says."""
        return self.cells.faults(state.cells_state, now_ns)

    def _without_tracked_cells(self, cells_state: CellsState, tracker_state: TrackerState) -> CellsState:
        tracks = tracker_state.tracks
        outside = outside_tracks(cells_state.hidden_map, tracks.poses_map, tracks.sizes_m, self.own_margin_m)
        return msgspec.structs.replace(
            cells_state,
            hidden_map=cells_state.hidden_map[outside],
            hidden_ns=cells_state.hidden_ns[outside],
            hidden_low=cells_state.hidden_low[outside],
            hidden_left=cells_state.hidden_left[outside],
        )
