import pytest

from contract import tracing
from contract.tracing import BOOKING, NO_SPANS, RideSpans, Span, root_id_of, trace_id_of


class Kept:
    def __init__(self) -> None:
        self.spans: list[Span] = []

    def add(self, span: Span) -> None:
        self.spans.append(span)

    def close(self) -> None:
        self.spans.clear()


def test_processes_that_know_only_the_ride_add_to_one_trace() -> None:
    server, vehicle = Kept(), Kept()
    RideSpans(server).add(["r1"], BOOKING, 1, 2)
    RideSpans(vehicle, vehicle_id="v").add(["r1", "r2"], "order.received", 3, 3)
    assert server.spans[0].trace_id == vehicle.spans[0].trace_id == trace_id_of("r1")
    assert vehicle.spans[0].parent_id == server.spans[0].span_id == root_id_of("r1")
    assert vehicle.spans[1].trace_id == trace_id_of("r2") != trace_id_of("r1")


def test_a_repeated_step_makes_no_second_span_and_another_vehicle_does() -> None:
    kept = Kept()
    rides = RideSpans(kept)
    assert rides.add(["r1"], "order.sent", 1, 1, vehicle_id="v1") == ("r1",)
    assert rides.add(["r1"], "order.sent", 2, 2, vehicle_id="v1") == ()
    assert rides.add(["r1"], "order.sent", 3, 3, vehicle_id="v2") == ("r1",)
    assert len({span.span_id for span in kept.spans}) == 2


def test_what_is_remembered_is_bounded(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tracing, "REMEMBERED_MAX", 2)
    rides = RideSpans(Kept())
    rides.add(["r1", "r2", "r3"], "order.sent", 1, 1)
    assert rides.add(["r3"], "order.sent", 1, 1) == ()
    assert rides.add(["r1"], "order.sent", 1, 1) == ("r1",)


def test_without_a_collector_nothing_is_opened() -> None:
    assert NO_SPANS.open("server") is None
