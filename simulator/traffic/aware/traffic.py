"""A recording in which people heed the vehicles of the world; recorded cars do not."""

from contract.geometry import Array
from simulator.traffic.actors import Bodies, no_bodies, together
from simulator.traffic.aware.acceptance import accepted_limits
from simulator.traffic.aware.params import ReactionParams
from simulator.traffic.aware.people import AwarePeople
from simulator.traffic.aware.ways import own_ways
from simulator.traffic.recordings import Clip
from simulator.traffic.replayed import ReplayedTraffic


class AwareTraffic:
    """Plays a clip from `from_s` on, without some cars; `hold` stops its clock and hides all bodies."""

    def __init__(
        self,
        clip: Clip,
        from_s: float,
        without: frozenset[int] = frozenset(),
        params: ReactionParams | None = None,
    ) -> None:
        people = [track for track in clip.tracks if not track.is_driven]
        params = params or ReactionParams()
        ways = own_ways([(track.times_s, track.states) for track in people])
        limits = accepted_limits(ways, clip.cars(), params)
        numbers = [track.number for track in people]
        self.people = AwarePeople(numbers, ways, limits, params, from_s, clip.ends_s)
        self._cars = ReplayedTraffic(clip, from_s, without | frozenset(numbers))
        self.hold = False

    @property
    def removed(self) -> dict[int, tuple[float, float, float]]:
        """No one: people who would appear in a vehicle's place wait outside the picture (`delayed`)."""
        return self._cars.removed

    @property
    def delayed(self) -> set[int]:
        return self.people.delayed

    def step(self, vehicles: Array, odometers_m: Array, ahead: Array, dt_s: float) -> None:
        """Advance the clock; people heed the vehicles."""
        if not self.hold:
            self._cars.step(vehicles, odometers_m, ahead, dt_s)
            self.people.step(vehicles, dt_s)

    def bodies(self) -> Bodies:
        """All bodies that are present now."""
        return no_bodies() if self.hold else together(self.people.bodies(), self._cars.bodies())
