"""How many of the people in view have a track with a person's label, by range."""

from dataclasses import dataclass, field

import numpy as np

from benchmarks.pedestrians.scenes import Moment, PeopleDrive, states_of
from contract.geometry import Array
from vehicle_agent.perception.camera.people_detector import HogPeopleDetector
from vehicle_agent.perception.camera.projection import person_regions
from vehicle_agent.perception.laser_people.people import LaserPeople, LaserPeopleState
from vehicle_agent.perception.laser_people.tracking import placed_at_base

RANGES_M = (10, 15, 20, 25, 30)
_BAND_M = 2.5
# A track belongs to a person who is this near.
_NEAR_M = 0.7
# A person who has been in view for so long must have a label; the paper's vehicle needs longer to stop.
SETTLED_NS = 1_000_000_000
# A person of whom more is hidden is not in view.
_HIDDEN_MAX = 0.4


@dataclass(slots=True)
class Samples:
    """One row for each person in view in each picture: range (m), tracked, labelled, single-look score."""

    ranges_m: list[float] = field(default_factory=list)
    tracked: list[bool] = field(default_factory=list)
    labelled: list[bool] = field(default_factory=list)
    people: int = 0

    def recall(self, range_m: float) -> tuple[int, float, float]:
        """(samples, share tracked, share labelled) of the people about range_m away."""
        band = np.abs(np.array(self.ranges_m) - range_m) <= _BAND_M
        count = int(band.sum())
        if not count:
            return 0, float("nan"), float("nan")
        return (
            count,
            float(np.mean(np.array(self.tracked)[band])),
            float(np.mean(np.array(self.labelled)[band])),
        )


class RecallScore:
    """Runs one drive after another through the room and compares with who is there."""

    def __init__(self, room: LaserPeople, detector: HogPeopleDetector) -> None:
        self._room, self._detector = room, detector
        self.samples = Samples()
        self.false_labels = 0

    def drive(self, drive: PeopleDrive) -> LaserPeopleState:
        """The state at the drive's end."""
        state = LaserPeopleState()
        since: dict[int, int] = {}
        false_ids: set[int] = set()
        for moment, state in states_of(drive, self._room, self._detector):
            if moment.shot is not None:
                self._compare(drive, moment, state, since)
                false_ids |= _false(moment, state)
        self.samples.people += len(since)
        self.false_labels += len(false_ids)
        return state

    def _compare(
        self, drive: PeopleDrive, moment: Moment, state: LaserPeopleState, since: dict[int, int]
    ) -> None:
        shot, tracks = moment.shot, state.tracks
        assert shot is not None
        places = moment.bodies.poses_map[:, :2]
        places_base = placed_at_base(places, moment.pose_map)
        ground = np.column_stack((places_base, np.zeros(len(places))))
        in_view = person_regions(drive.camera.model, ground, 1.7, 0.0).is_seen & (shot.hidden < _HIDDEN_MAX)
        followed = self._room.tracker.is_followed(tracks)
        apart = np.linalg.norm(places[:, None] - tracks.places_map[None], axis=2)
        near = apart < _NEAR_M
        for k in range(len(places)):
            number = int(moment.bodies.numbers[k])
            if not in_view[k]:
                since.pop(number, None)
                continue
            first_ns = since.setdefault(number, moment.stamp_ns)
            if moment.stamp_ns - first_ns < SETTLED_NS:
                continue
            self.samples.ranges_m.append(float(np.hypot(*places_base[k])))
            self.samples.tracked.append(bool((near[k] & followed).any()))
            self.samples.labelled.append(bool((near[k] & tracks.is_person).any()))


def _false(moment: Moment, state: LaserPeopleState) -> set[int]:
    """Labelled tracks that are farther than 1.5 m from every person."""
    tracks = state.tracks
    chosen = tracks.is_person & (tracks.seen_ns == tracks.stamp_ns)
    places: Array = moment.bodies.poses_map[moment.bodies.people, :2]
    if not len(places):
        return set(tracks.ids[chosen].tolist())
    apart = np.linalg.norm(tracks.places_map[:, None] - places[None], axis=2).min(axis=1)
    return set(tracks.ids[chosen & (apart > 1.5)].tolist())
