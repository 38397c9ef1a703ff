"""Which sections follow which, and what standing vehicles cut off."""

import pytest

from contract.roads.model import RestingPlace, Section, Stop
from contract.roads.section_graph import SectionGraph, broken_promises
from tests.contract.roads.ring_map import ring_map

RING = ring_map()
GRAPH = SectionGraph(RING.sections, [(lane.lane_id, lane.successors) for lane in RING.lanes])


def ids(numbers: set[int]) -> set[str]:
    return {GRAPH.sections[number].section_id for number in numbers}


@pytest.mark.parametrize(
    ("s_m", "section_id"),
    [(-1.0, "side-0/0"), (0.0, "side-0/0"), (24.9, "side-0/0"), (25.0, "side-0/1"), (500.0, "side-0/3")],
)
def test_a_place_lies_in_the_section_that_begins_there_or_before_it(s_m: float, section_id: str) -> None:
    assert GRAPH.sections[GRAPH.at("side-0", s_m)].section_id == section_id


def test_from_anywhere_on_a_ring_everything_can_be_reached_until_a_section_is_closed() -> None:
    start = GRAPH.numbers["side-0/1"]
    assert len(GRAPH.reach(start, ())) == len(RING.sections)
    closed = {GRAPH.numbers["corner-0/0"]}
    assert ids(GRAPH.reach(start, closed)) == {"side-0/1", "side-0/2", "side-0/3"}
    behind = ids(GRAPH.reach(start, closed, backwards=True))
    assert behind == {section.section_id for section in RING.sections} - {
        "corner-0/0",
        "side-0/2",
        "side-0/3",
    }


def test_who_stands_in_a_section_keeps_others_out_of_it_and_of_what_conflicts_with_it() -> None:
    sections = (
        Section("a", "l", 0.0, 10.0, ("c",)),
        Section("b", "l", 10.0, 20.0),
        Section("c", "m", 0.0, 5.0, ("a",)),
    )
    graph = SectionGraph(sections, [("l", ()), ("m", ())])
    assert graph.shadow_of([0]) == {0, 2}
    assert graph.shadow_of([0, 1]) == {0, 1, 2}
    assert graph.shadow_of([]) == set()


def test_a_resting_place_on_the_only_road_cuts_the_others_off_and_each_is_named() -> None:
    stops = (Stop("gate", "Gate", "side-1", 60.0),)
    alone = (RestingPlace("one", "side-0", 60.0),)
    assert broken_promises(GRAPH, alone, stops) == ()
    two = (*alone, RestingPlace("two", "side-2", 60.0))
    assert broken_promises(GRAPH, two, stops) == (
        ("one", "cannot be reached from stop gate"),
        ("two", "stop gate cannot be reached from here"),
    )
    same = (*alone, RestingPlace("three", "side-0", 55.0))
    assert [place for place, _ in broken_promises(GRAPH, same, stops)] == ["one", "three"]
    assert broken_promises(GRAPH, same, stops)[0][1] == "another resting place keeps this one occupied"
