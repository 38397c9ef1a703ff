"""Which section follows which, and what can be reached when some of them are taken."""

import itertools
from collections import deque
from collections.abc import Collection, Iterable, Sequence

from contract.roads.model import RestingPlace, Section, Stop


class SectionGraph:
    """The sections of a map, numbered by their place in `sections`.

    lanes  (lane_id, successor lane ids) of every lane.
    """

    def __init__(self, sections: Sequence[Section], lanes: Iterable[tuple[str, Sequence[str]]]) -> None:
        self.sections = tuple(sections)
        self.numbers = {section.section_id: i for i, section in enumerate(self.sections)}
        self.shadows: tuple[frozenset[int], ...] = tuple(
            frozenset((i, *(self.numbers[c] for c in section.conflicts)))
            for i, section in enumerate(self.sections)
        )
        self._of_lane: dict[str, list[int]] = {}
        for i in sorted(range(len(self.sections)), key=lambda k: self.sections[k].s_from_m):
            self._of_lane.setdefault(self.sections[i].lane_id, []).append(i)
        self.after: list[list[int]] = [[] for _ in self.sections]
        self.before: list[list[int]] = [[] for _ in self.sections]
        for lane_id, successors in lanes:
            chain = self._of_lane.get(lane_id, [])
            for first, second in itertools.pairwise(chain):
                self._join(first, second)
            for successor in successors:
                if chain and successor in self._of_lane:
                    self._join(chain[-1], self._of_lane[successor][0])

    def _join(self, first: int, second: int) -> None:
        self.after[first].append(second)
        self.before[second].append(first)

    def at(self, lane_id: str, s_m: float) -> int:
        """The number of the section that holds s_m on the lane, clamped to the lane's ends."""
        chain = self._of_lane[lane_id]
        return next((i for i in reversed(chain) if self.sections[i].s_from_m <= s_m), chain[0])

    def reach(self, start: int, closed: Collection[int], *, backwards: bool = False) -> set[int]:
        """The sections that can be reached from start, itself included, without entering closed ones."""
        ways = self.before if backwards else self.after
        seen = {start}
        queue = deque(seen)
        while queue:
            for follower in ways[queue.popleft()]:
                if follower not in seen and follower not in closed:
                    seen.add(follower)
                    queue.append(follower)
        return seen

    def shadow_of(self, numbers: Iterable[int]) -> set[int]:
        """Everything that shuttles standing in these sections keep others out of."""
        shadow: set[int] = set()
        for number in numbers:
            shadow |= self.shadows[number]
        return shadow


def broken_promises(
    graph: SectionGraph, places: Sequence[RestingPlace], stops: Sequence[Stop]
) -> tuple[tuple[str, str], ...]:
    """(place_id, what fails) wherever resting at every place at once cuts a place off from a stop."""
    standing = [graph.at(place.lane_id, place.s_m) for place in places]
    wanted = {stop.stop_id: graph.at(stop.lane_id, stop.s_m) for stop in stops}
    broken: list[tuple[str, str]] = []
    for k, (place, here) in enumerate(zip(places, standing, strict=True)):
        closed = graph.shadow_of(standing[:k] + standing[k + 1 :])
        if here in closed:
            broken.append((place.place_id, "another resting place keeps this one occupied"))
            continue
        onward, back = graph.reach(here, closed), graph.reach(here, closed, backwards=True)
        for stop_id, number in wanted.items():
            if number not in onward or number in closed:
                broken.append((place.place_id, f"stop {stop_id} cannot be reached from here"))
            elif number not in back:
                broken.append((place.place_id, f"cannot be reached from stop {stop_id}"))
    return tuple(broken)
