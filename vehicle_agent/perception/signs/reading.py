"""Obstacle cells as in `cells`, and the signs beside the way."""

import msgspec

from vehicle_agent.perception.cells import CellsState, HeightMapPerception
from vehicle_agent.perception.signs.tracks import SignsState, SignTracker, seen_signs
from vehicle_agent.signals import Detections, Ego, Fault, PerceptionInput, SignPercept
from vehicle_agent.signals.pose_history import pose_at


class SignReadingState(msgspec.Struct, frozen=True):
    """The states of cells and signs, and the last detections."""

    cells_state: CellsState
    signs_state: SignsState
    detections: Detections


class SignReadingPerception(msgspec.Struct, frozen=True):
    """Cells and signs together. The detections have the stamp of the cells; signs may be older."""

    cells: HeightMapPerception
    signs: SignTracker = SignTracker()

    def initial(self) -> SignReadingState:
        cells_state = self.cells.initial()
        return SignReadingState(cells_state, SignsState(), cells_state.detections)

    def step(
        self, state: SignReadingState, percepts: tuple[PerceptionInput, ...], ego: Ego
    ) -> tuple[Detections, SignReadingState]:
        """The detections; the same object until there is a newer scan or the signs of one."""
        cells, cells_state = self.cells.step(state.cells_state, percepts, ego)
        signs_state = state.signs_state
        scans = [percept for percept in percepts if isinstance(percept, SignPercept)]
        # Without a position a sign has no place.
        for percept in sorted(scans, key=lambda scan: scan.stamp_ns) if ego.valid else ():
            if percept.stamp_ns > signs_state.stamp_ns:
                pose_map = pose_at(cells_state.poses, percept.stamp_ns)
                signs_state = self.signs.step(signs_state, percept, pose_map)
        if cells is state.cells_state.detections and signs_state is state.signs_state:
            return state.detections, msgspec.structs.replace(state, cells_state=cells_state)
        signs = seen_signs(signs_state) if signs_state is not state.signs_state else state.detections.signs
        detections = msgspec.structs.replace(cells, signs=signs)
        return detections, SignReadingState(cells_state, signs_state, detections)

    def faults(self, state: SignReadingState, now_ns: int) -> tuple[Fault, ...]:
        """What is wrong with single lidars, as their driver says."""
        return self.cells.faults(state.cells_state, now_ns)
