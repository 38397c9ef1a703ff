"""Cells and tracks as in `tracks`, and the signs beside the way."""

import msgspec

from vehicle_agent.perception.signs.tracks import SignsState, SignTracker, seen_signs
from vehicle_agent.perception.tracks import TrackingPerception, TracksState
from vehicle_agent.signals import Detections, Ego, Fault, PerceptionInput, SignPercept
from vehicle_agent.signals.pose_history import pose_at


class SignReadingState(msgspec.Struct, frozen=True):
    """The states of road users and signs, and the last detections."""

    around: TracksState
    signs_state: SignsState
    detections: Detections


class SignReadingPerception(msgspec.Struct, frozen=True):
    """Cells, tracks and signs together. Signs may be older than the detections' stamp."""

    around: TrackingPerception
    signs: SignTracker = SignTracker()

    def initial(self) -> SignReadingState:
        around = self.around.initial()
        return SignReadingState(around, SignsState(), around.detections)

    def step(
        self, state: SignReadingState, percepts: tuple[PerceptionInput, ...], ego: Ego
    ) -> tuple[Detections, SignReadingState]:
        """The detections; the same object until there is a newer scan, tracks or signs."""
        found, around = self.around.step(state.around, percepts, ego)
        signs_state = state.signs_state
        scans = [percept for percept in percepts if isinstance(percept, SignPercept)]
        # Without a position a sign has no place.
        for percept in sorted(scans, key=lambda scan: scan.stamp_ns) if ego.valid else ():
            if percept.stamp_ns > signs_state.stamp_ns:
                pose_map = pose_at(around.cells_state.poses, percept.stamp_ns)
                signs_state = self.signs.step(signs_state, percept, pose_map)
        if found is state.around.detections and signs_state is state.signs_state:
            return state.detections, msgspec.structs.replace(state, around=around)
        signs = seen_signs(signs_state) if signs_state is not state.signs_state else state.detections.signs
        detections = msgspec.structs.replace(found, signs=signs)
        return detections, SignReadingState(around, signs_state, detections)

    def faults(self, state: SignReadingState, now_ns: int) -> tuple[Fault, ...]:
        """What is wrong with single lidars, as their driver says."""
        return self.around.faults(state.around, now_ns)
