"""Edges: way segments joined and cut, so that each leads from one choice to the next."""

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from contract.geometry import Array
from server.feeds.roads.osm.drivable import Driving
from server.feeds.roads.osm.way_segments import Position, WaySegment


@dataclass(frozen=True, slots=True)
class Edge:
    """A stretch of road without a choice in it; `driving.direction` is along keys, or both ways (0)."""

    edge_id: str
    keys: tuple[int, ...]
    points: Array
    driving: Driving
    way_ids: tuple[int, ...]
    name: str
    name_en: str

    @property
    def length_m(self) -> float:
        return float(np.hypot(*np.diff(self.points, axis=0).T).sum())

    @property
    def label(self) -> str:
        """What a person finds it by: the first way's id and name."""
        named = f" ({self.name})" if self.name else ""
        return f"way {self.way_ids[0]}{named}"


@dataclass(frozen=True, slots=True)
class _Chain:
    keys: tuple[int, ...]
    driving: Driving
    way_ids: tuple[int, ...]
    names: tuple[tuple[str, str, float], ...]


def edges_of(segments: Sequence[WaySegment], positions: dict[int, Position]) -> list[Edge]:
    """The edges, in a fixed order."""
    chains = _joined(_chains(segments, positions))
    chains.sort(key=lambda chain: (chain.way_ids[0], chain.keys))
    edges: list[Edge] = []
    used: dict[int, int] = {}
    for chain in chains:
        way_id = chain.way_ids[0]
        number = used[way_id] = used.get(way_id, 0) + 1
        name, name_en, _ = max(chain.names, key=lambda entry: (bool(entry[0]), entry[2]))
        points = np.array([positions[key] for key in chain.keys])
        edges.append(
            Edge(
                f"{way_id}.{number}",
                chain.keys,
                points,
                chain.driving,
                chain.way_ids,
                name,
                name_en,
            )
        )
    return edges


def _chains(segments: Sequence[WaySegment], positions: dict[int, Position]) -> list[_Chain]:
    """Way segments cut at every key that another one touches or that they touch twice, along the driving."""
    touches: dict[int, int] = {}
    for segment in segments:
        for key in segment.keys:
            touches[key] = touches.get(key, 0) + 1
    chains = []
    for segment in segments:
        keys, how = segment.keys, segment.driving
        if how.direction < 0:
            keys, how = keys[::-1], replace(how, direction=1)
        cuts = [0, *(k for k in range(1, len(keys) - 1) if touches[keys[k]] > 1), len(keys) - 1]
        for first, last in itertools.pairwise(cuts):
            piece = keys[first : last + 1]
            length = sum(math.dist(positions[a], positions[b]) for a, b in itertools.pairwise(piece))
            names = ((segment.name, segment.name_en, length),)
            chains.append(_Chain(piece, how, (segment.way_id,), names))
    return chains


def _joined(chains: list[_Chain]) -> list[_Chain]:
    """Two chains that meet where nothing else does, and are driven alike, made one."""
    live: dict[int, _Chain] = dict(enumerate(chains))
    ends: dict[int, list[int]] = {}
    for number, chain in live.items():
        for key in (chain.keys[0], chain.keys[-1]):
            ends.setdefault(key, []).append(number)
    for key in sorted(ends):
        meeting = ends[key]
        if len(meeting) != 2 or meeting[0] == meeting[1]:
            continue
        one, other = live[meeting[0]], live[meeting[1]]
        if not _alike(one.driving, other.driving):
            continue
        if one.driving.direction == 1 and (one.keys[0] == key) == (other.keys[0] == key):
            continue
        merged = _merge(one, other, key)
        kept, gone = meeting
        live[kept] = merged
        del live[gone]
        for far in {other.keys[0], other.keys[-1]} - {key}:
            ends[far] = [kept if number == gone else number for number in ends[far]]
    return list(live.values())


def _alike(one: Driving, other: Driving) -> bool:
    same_speed = abs(one.speed_mps - other.speed_mps) < 0.1
    return same_speed and (one.direction, one.can_pass, one.scenario) == (
        other.direction,
        other.can_pass,
        other.scenario,
    )


def _merge(one: _Chain, other: _Chain, key: int) -> _Chain:
    """One chain through `key`; both one-way chains lead the same way there."""
    first, second = (one, other) if one.keys[-1] == key else (other, one)
    before = first.keys if first.keys[-1] == key else first.keys[::-1]
    after = second.keys if second.keys[0] == key else second.keys[::-1]
    width = min(one.driving.width_m, other.driving.width_m)
    return _Chain(
        before + after[1:],
        replace(one.driving, width_m=width),
        (*one.way_ids, *(way for way in other.way_ids if way not in one.way_ids)),
        one.names + other.names,
    )
