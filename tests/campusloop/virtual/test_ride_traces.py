"""A ride of a virtual campus leaves one trace, from the HTTP request to the first CAN frame."""

from pathlib import Path

import pytest

from campusloop.virtual.campus import CampusOptions, VirtualCampus
from contract.tracing import BOOKING, Span, root_id_of, trace_id_of
from tests.contract.roads.ring_map import ring_map
from tests.faults.real_campus import nearest_pair

STEPS = [
    "booking",
    "booking.transaction",
    "booking.decision",
    "order.sent",
    "order.received",
    "order.accepted",
    "motion.commanded",
    "can.frame_sent",
]
WITHIN_S = 60.0


class KeptSpans:
    def __init__(self) -> None:
        self.spans: list[Span] = []

    def add(self, span: Span) -> None:
        self.spans.append(span)

    def close(self) -> None:
        raise AssertionError("the campus does not own them")


def a_campus(folder: Path, spans: KeptSpans | None) -> VirtualCampus:
    options = CampusOptions(ring_map(), folder, vehicles=1, traffic=None, spans=spans)
    campus = VirtualCampus(options)
    campus.start()
    return campus


def book(campus: VirtualCampus) -> str:
    origin, target = nearest_pair(campus.options.road_map)
    body = {"from_stop": origin, "to_stop": target}
    headers = {"X-Request-Id": "from-the-phone"}
    answer = campus.call(campus.client.post("/api/v1/rides", json=body, headers=headers))
    assert answer.json()["state"] == "assigned", answer.text
    ride_id: str = answer.json()["ride_id"]
    return ride_id


@pytest.fixture(scope="module")
def trace(tmp_path_factory: pytest.TempPathFactory) -> tuple[str, list[Span]]:
    """The ride, and all spans until a frame was sent for it."""
    kept = KeptSpans()
    campus = a_campus(tmp_path_factory.mktemp("campus"), kept)
    ride_id = book(campus)
    campus.conductor.run_until(lambda: any(span.name == STEPS[-1] for span in kept.spans), WITHIN_S)
    campus.stop()
    return ride_id, kept.spans


def test_every_step_of_a_ride_is_in_its_trace_once(trace: tuple[str, list[Span]]) -> None:
    ride_id, spans = trace
    assert sorted(span.name for span in spans) == sorted(STEPS)
    assert {span.trace_id for span in spans} == {trace_id_of(ride_id)}
    assert len({span.span_id for span in spans}) == len(STEPS)


def test_the_steps_end_in_their_order(trace: tuple[str, list[Span]]) -> None:
    ends = {span.name: span.end_ns for span in trace[1]}
    after_booking = [ends[name] for name in STEPS[3:]]
    assert after_booking == sorted(after_booking)
    assert ends["booking.decision"] <= ends["booking.transaction"] <= ends["booking"]
    assert all(span.begin_ns <= span.end_ns for span in trace[1])


def test_the_booking_is_the_root_and_names_the_request(trace: tuple[str, list[Span]]) -> None:
    ride_id, spans = trace
    (root,) = [span for span in spans if not span.parent_id]
    assert (root.name, root.span_id) == (BOOKING, root_id_of(ride_id))
    assert {span.parent_id for span in spans if span is not root} == {root.span_id}
    assert root.attributes == {"ride_id": ride_id, "request_id": "from-the-phone"}


def test_the_vehicle_is_named_from_the_order_on(trace: tuple[str, list[Span]]) -> None:
    named = {span.name for span in trace[1] if span.attributes.get("vehicle_id") == "shuttle-1"}
    assert named == set(STEPS[3:])
