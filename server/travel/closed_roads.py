"""The sections that closures close, and how a shuttle on a closed road leaves it."""

from collections.abc import Collection, Iterable
from datetime import datetime

from contract.roads.network import RoadNetwork
from server.domain.roads.closures import Closure, ClosureState


def sections_closed(closures: Iterable[Closure], network: RoadNetwork) -> frozenset[str]:
    """Closed by those in force. Lanes and sections that another map had are left out."""
    in_force = (closure for closure in closures if closure.state is ClosureState.IN_FORCE)
    return frozenset(section_id for closure in in_force for section_id in sections_of(closure, network))


def sections_closed_within(
    closures: Iterable[Closure], network: RoadNetwork, begins: datetime, ends: datetime
) -> frozenset[str]:
    """Closed at some time within [begins, ends], as far as is known now."""
    then = (closure for closure in closures if closure.overlaps(begins, ends))
    return frozenset(section_id for closure in then for section_id in sections_of(closure, network))


def way_out(network: RoadNetwork, section_id: str, closed: Collection[str]) -> frozenset[str]:
    """The closed sections that a vehicle in this one may drive through, to leave closed road; empty where it
    does not stand on any."""
    if section_id not in closed:
        return frozenset()
    found = {section_id}
    waiting = [section_id]
    while waiting:
        for following in _following(network, waiting.pop()):
            if following in closed and following not in found:
                found.add(following)
                waiting.append(following)
    return frozenset(found)


def sections_of(closure: Closure, network: RoadNetwork) -> Iterable[str]:
    """The sections of this map that the closure names."""
    for lane_id in closure.lane_ids:
        if lane_id in network.lanes:
            yield from (section.section_id for section in network.sections_of(lane_id))
    yield from (section_id for section_id in closure.section_ids if section_id in network.sections)


def _following(network: RoadNetwork, section_id: str) -> tuple[str, ...]:
    lane_id = network.sections[section_id].lane_id
    on_lane = [section.section_id for section in network.sections_of(lane_id)]
    number = on_lane.index(section_id)
    if number + 1 < len(on_lane):
        return (on_lane[number + 1],)
    return tuple(network.sections_of(after)[0].section_id for after in network.successors(lane_id))
