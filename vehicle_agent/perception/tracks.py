"""Obstacle cells as in the GEM stack, and beside them tracks of everybody who moves."""

import msgspec

from vehicle_agent.perception.cells import CellsState, HeightMapPerception
from vehicle_agent.perception.own_cells import outside_tracks
from vehicle_agent.perception.pose_history import pose_at
from vehicle_agent.perception.tracker import AlphaBetaTracker, TrackerState
from vehicle_agent.signals import Detections, Ego, Percept, TrackPercept


class TracksState(msgspec.Struct, frozen=True):
    """What perception remembers: the cells' memory, the tracks', and what was told last."""

    sighting: CellsState
    kept: TrackerState
    seen: Detections


class TrackingPerception(msgspec.Struct, frozen=True):
    """has_lidar False: nobody waits for cells, as in a simulation of tracks alone.

    own_margin_m: cells this near to a track are its own. Under the lidar's rays they are not remembered: who
    is followed walks on, and would leave a ghost behind
    """

    cells: HeightMapPerception
    keeper: AlphaBetaTracker = AlphaBetaTracker()
    has_lidar: bool = True
    own_margin_m: float = 0.5

    def initial(self) -> TracksState:
        sighting = self.cells.initial()
        return TracksState(sighting, TrackerState(), sighting.seen)

    def step(
        self, state: TracksState, percepts: tuple[Percept, ...], ego: Ego
    ) -> tuple[Detections, TracksState]:
        """As old as the older of its two sources; the same object while neither brings anything new."""
        cells, sighting = self.cells.step(state.sighting, percepts, ego)
        newer = [
            percept
            for percept in percepts
            if isinstance(percept, TrackPercept) and percept.stamp_ns > state.kept.tracks.stamp_ns
        ]
        kept = state.kept
        for percept in sorted(newer, key=lambda item: item.stamp_ns):
            kept = self.keeper.step(kept, percept, pose_at(sighting.poses, percept.stamp_ns))
        if kept is state.kept and cells is state.sighting.seen:
            return state.seen, msgspec.structs.replace(state, sighting=sighting)
        if cells is not state.sighting.seen:
            sighting = self._without_followed(sighting, kept)
        stamp_ns = kept.tracks.stamp_ns
        if self.has_lidar:
            stamp_ns = min(stamp_ns, cells.stamp_ns)
        seen = Detections(stamp_ns, cells.points_map, cells.blind and self.has_lidar, kept.tracks)
        return seen, TracksState(sighting, kept, seen)

    def _without_followed(self, sighting: CellsState, kept: TrackerState) -> CellsState:
        tracks = kept.tracks
        others = outside_tracks(sighting.hidden_map, tracks.poses_map, tracks.sizes_m, self.own_margin_m)
        return msgspec.structs.replace(
            sighting, hidden_map=sighting.hidden_map[others], hidden_ns=sighting.hidden_ns[others]
        )
