"""Turn signals on a whole drive: round a bend, to a stop and away from it, by the module's reports."""

import itertools
from functools import partial
from pathlib import Path

import msgspec

from simulator.world import WorldOptions
from tests.vehicle_agent.driven_shuttle import DrivenShuttle
from tests.vehicle_agent.mission.ring import ring
from vehicle_agent.config import LidarMount, load_profile
from vehicle_agent.onboard.driving_view import report_with_driving_view
from vehicle_agent.signals import TurnSignal

PROFILES = Path(__file__).resolve().parents[3] / "vehicle_agent" / "profiles"
START, STOP, REST = ("south", 72.0), ("north", 22.0), ("north", 70.0)


def driven(name: str) -> tuple[DrivenShuttle, list[TurnSignal | None]]:
    """(the shuttle at its rest, its turn signals in order) after a bend to the left and a stop."""
    profile = load_profile(PROFILES / f"{name}.toml")
    profile = msgspec.structs.replace(profile, lidar=LidarMount(rate_hz=0.0))
    shuttle = DrivenShuttle(ring(), START, profile, WorldOptions(traffic=None, lidar=False))
    stop = shuttle.visit("stop", *STOP, START, dwell_s=2.0)
    rest = shuttle.visit("rest", *REST, STOP, kind="rest", dwell_s=0.0)
    shuttle.say(shuttle.order_for((stop, rest), START))
    shuttle.run(1.0)
    shuttle.resume()
    seen: list[TurnSignal | None] = []

    def note(drive: DrivenShuttle, until: str) -> bool:
        assert drive.outputs is not None
        seen.append(drive.outputs.flow.motion.turn_signal)
        return drive.state.mission.doors.phase == until

    assert shuttle.run(60.0, partial(note, until="open"))
    assert shuttle.run(20.0, partial(note, until="closed"))
    shuttle.run(12.0, partial(note, until="never"))
    return shuttle, [signal for signal, _ in itertools.groupby(seen)]


def test_the_bend_the_stop_and_the_departure_are_signalled_by_wire() -> None:
    shuttle, signals = driven("gem-e2")
    assert signals == ["none", "left", "none", "right", "hazard", "left", "none"]
    assert shuttle.outputs is not None
    view = report_with_driving_view(shuttle.outputs).driving
    assert view is not None
    assert (view.turn_signal, view.horn) == ("none", False)
    assert view.headlights in ("off", "low")


def test_a_cart_without_signals_by_wire_reports_none() -> None:
    shuttle, signals = driven("nus-cart")
    assert signals == [None]
    assert shuttle.outputs is not None
    view = report_with_driving_view(shuttle.outputs).driving
    assert view is not None
    assert (view.turn_signal, view.headlights, view.horn) == (None, None, None)
