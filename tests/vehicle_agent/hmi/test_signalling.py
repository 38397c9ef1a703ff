"""Turn signals, headlights and horn: what the vehicle is about to do, told in time and without flicker."""

import datetime as dt
import math
from typing import Any

import msgspec
import numpy as np
import pytest

from contract.roads.model import Lane
from contract.roads.routing import ReferenceLine
from tests.vehicle_agent.hmi.test_announcer import PATH, TASK
from vehicle_agent.config import Profile, Signalling
from vehicle_agent.hmi.signalling import SignallingState, VehicleSignalling, turns_of
from vehicle_agent.hmi.sunlight import sun_elevation_rad
from vehicle_agent.signals import GuardStatus, VehicleSignals
from vehicle_agent.stacks.rooms import announcer

TICK_NS = 20_000_000
SHANGHAI = (31.32, 121.39)


def straight_line(turn_from_m: float) -> ReferenceLine:
    """100 m straight on, of which the lane "turn" is from turn_from_m on."""
    s = np.arange(0.0, 100.5, 0.5)
    points = np.column_stack((s, np.zeros(len(s))))
    numbers = (s >= turn_from_m).astype(np.int64)
    return ReferenceLine(points, s, np.zeros(len(s)), np.full(len(s), 3.0), numbers, ("road", "turn"), ())


LINE = straight_line(1000.0)


class Lamps:
    """The signals of a shuttle for which the ticks are counted."""

    def __init__(self, **settings: Any) -> None:
        self.room = VehicleSignalling(turns={"turn": "left"}, **settings)
        self.state, self.now_ns = SignallingState(), 0
        self.shown = VehicleSignals()

    def run(
        self,
        seconds: float,
        mode: str = "autonomous",
        reason: Any = None,
        imminent: bool = False,
        aside_m: float | None = None,
        stop_m: float = 90.0,
        **task: Any,
    ) -> VehicleSignals:
        path = msgspec.structs.replace(PATH, stop_m=stop_m)
        task.setdefault("line", LINE)
        if aside_m is not None:
            here_m = task.get("s_m", 0.0)
            points = np.column_stack((here_m + np.arange(15.0), np.full(15, aside_m)))
            path = msgspec.structs.replace(path, points_map=points)
        guard_status = GuardStatus(mode, "", (), reason, "", imminent)  # type: ignore[arg-type]
        for _ in range(round(seconds * 50)):
            self.now_ns += TICK_NS
            self.shown, self.state = self.room.step(
                self.state, msgspec.structs.replace(TASK, **task), path, guard_status, self.now_ns
            )
        return self.shown


def test_a_shuttle_on_its_way_shows_nothing() -> None:
    assert Lamps().run(3.0).turn == "none"


@pytest.mark.parametrize(
    ("mode", "reason", "turn"),
    [
        ("minimal_risk", "fault", "hazard"),
        ("fault", "fault", "hazard"),
        ("held", "operator_hold", "hazard"),
        ("held", "off_route", "hazard"),
        ("held", "just_started", "none"),
        ("manual", "takeover", "none"),
    ],
)
def test_a_shuttle_that_does_not_drive_warns_where_nobody_expects_it(
    mode: str, reason: str, turn: str
) -> None:
    assert Lamps().run(0.1, mode, reason).turn == turn


def test_a_stop_is_told_towards_the_kerb_then_hazard_lights_then_away_from_the_kerb() -> None:
    lamps = Lamps()
    assert lamps.run(3.0, stop_m=16.0).turn == "none"
    assert lamps.run(0.1, stop_m=14.0).turn == "right"
    assert lamps.run(2.0, mode="autonomous", stop_m=0.0).turn == "right"
    assert lamps.run(2.0, **{"mode": "autonomous", "stop_m": 0.0, "doors_open": True}).turn == "hazard"
    closed = msgspec.structs.replace(TASK, mode="dwell")
    assert (
        lamps.room.step(lamps.state, closed, PATH, GuardStatus("autonomous", "", ()), lamps.now_ns + 1)[
            0
        ].turn
        == "left"
    )
    lamps.run(2.5)
    assert lamps.shown.turn == "left"
    assert lamps.run(6.0).turn == "none"


def test_a_stop_that_is_not_free_and_a_hold_point_are_not_told() -> None:
    assert Lamps().run(3.0, stop_m=5.0, waiting_for="section").turn == "none"
    assert (
        Lamps().run(3.0, stop_m=5.0, **{"reason": None, "stop_name": "", "stop_name_en": ""}).turn == "none"
    )


@pytest.mark.parametrize(("s_m", "turn"), [(10.0, "none"), (24.0, "none"), (25.5, "left"), (60.0, "left")])
def test_a_turn_is_told_25_m_before_it_and_until_its_end(s_m: float, turn: str) -> None:
    assert Lamps().run(0.1, line=straight_line(50.0), s_m=s_m).turn == turn


def test_the_stop_before_the_turn_and_the_turn_before_the_stop_are_told_first() -> None:
    line = straight_line(50.0)
    assert Lamps().run(0.1, line=line, s_m=40.0, stop_m=5.0).turn == "right"
    assert Lamps().run(0.1, line=line, s_m=40.0, stop_m=14.0).turn == "left"


@pytest.mark.parametrize(("aside_m", "turn"), [(0.0, "none"), (0.4, "none"), (0.8, "left"), (-0.8, "right")])
def test_leaving_the_line_for_an_obstacle_is_told(aside_m: float, turn: str) -> None:
    assert Lamps().run(0.1, line=straight_line(99.0), s_m=10.0, aside_m=aside_m).turn == turn


def test_coming_back_to_the_line_is_told_to_the_other_side() -> None:
    assert Lamps().run(0.1, line=straight_line(99.0), s_m=10.0, d_m=0.9, aside_m=0.0).turn == "right"


def test_a_signal_that_is_wanted_for_a_moment_blinks_for_two_seconds_and_hazard_lights_come_at_once() -> None:
    lamps = Lamps()
    lamps.run(0.02, line=straight_line(99.0), s_m=10.0, aside_m=0.8)
    assert lamps.run(1.8).turn == "left"
    assert lamps.run(0.02, "minimal_risk", "fault").turn == "hazard"
    assert lamps.run(0.02).turn == "none"


def at(hour: float, day: int = 80) -> int:
    """Nanoseconds of UTC, by Shanghai's clock on a day of 2026."""
    local = dt.datetime(2026, 1, 1, tzinfo=dt.timezone(dt.timedelta(hours=8))) + dt.timedelta(
        days=day, hours=hour
    )
    return round(local.timestamp() * 1e9)


@pytest.mark.parametrize(
    ("hour", "lights"),
    [(12.0, "off"), (9.0, "off"), (17.0, "off"), (18.5, "low"), (23.0, "low"), (5.0, "low")],
)
def test_at_dusk_the_lights_are_on(hour: float, lights: str) -> None:
    assert Lamps(place_deg=SHANGHAI).run(0.1, utc_ns=at(hour)).headlights == lights


def test_the_lights_are_on_until_somebody_says_what_time_it_is() -> None:
    lamps = Lamps(place_deg=SHANGHAI)
    assert lamps.run(1.0).headlights == "low"
    assert lamps.run(0.02, utc_ns=at(12.0)).headlights == "off"


@pytest.mark.parametrize(("setting", "lights"), [("always", "low"), ("off", "off")])
def test_a_profile_may_want_the_lights_always_or_never(setting: str, lights: str) -> None:
    assert Lamps(place_deg=SHANGHAI, headlights=setting).run(0.1, utc_ns=at(12.0)).headlights == lights
    assert Lamps(place_deg=SHANGHAI, headlights=setting).run(0.1, utc_ns=at(23.0)).headlights == lights


@pytest.mark.parametrize(
    ("when", "latitude_deg", "longitude_deg", "elevation_deg"),
    [
        # The sun is overhead on the tropic at midsummer's noon, on the horizon at an equinox's sunrise.
        (dt.datetime(2026, 6, 21, 12, 2, tzinfo=dt.UTC), 23.44, 0.0, 90.0),
        (dt.datetime(2026, 12, 21, 11, 58, tzinfo=dt.UTC), 0.0, 0.0, 66.56),
        (dt.datetime(2026, 3, 20, 12, 7, tzinfo=dt.UTC), 51.48, 0.0, 38.5),
        (dt.datetime(2026, 3, 20, 6, 8, tzinfo=dt.UTC), 0.0, 0.0, 0.0),
        (dt.datetime(2026, 6, 21, 0, 2, tzinfo=dt.UTC), 80.0, 0.0, 13.44),
    ],
)
def test_the_sun_stands_where_astronomy_says(
    when: dt.datetime, latitude_deg: float, longitude_deg: float, elevation_deg: float
) -> None:
    utc_s = when.timestamp()
    found = math.degrees(sun_elevation_rad(utc_s, latitude_deg, longitude_deg))
    assert found == pytest.approx(elevation_deg, abs=0.5)


def test_the_horn_sounds_half_a_second_when_a_contact_is_imminent_and_not_again_for_ten() -> None:
    lamps = Lamps()
    assert not lamps.run(1.0).horn
    assert lamps.run(0.02, imminent=True).horn
    assert lamps.run(0.44, imminent=True).horn
    assert not lamps.run(5.0, imminent=True).horn
    lamps.run(6.0)
    assert lamps.run(0.02, imminent=True).horn


def test_a_profile_may_want_no_horn() -> None:
    assert not Lamps(horn="never").run(0.1, imminent=True).horn


def test_the_profile_s_wishes_reach_the_room() -> None:
    wishes = Signalling(kerb="left", turn_ahead_m=40.0, stop_ahead_m=10.0, headlights="always", horn="never")
    room = announcer(Profile(signalling=wishes)).signalling
    assert (room.kerb, room.turn_ahead_m, room.stop_ahead_m) == ("left", 40.0, 10.0)
    assert (room.headlights, room.horn) == ("always", "never")


def test_lanes_across_a_junction_turn_off_where_they_bend() -> None:
    angle = np.linspace(0.0, math.pi / 2.0, 20)
    left = tuple((float(x), float(y)) for x, y in zip(5 * np.sin(angle), 5 - 5 * np.cos(angle), strict=True))
    right = tuple((x, -y) for x, y in left)
    ahead = tuple((float(x), 0.0) for x in range(10))

    def lane(name: str, kind: Any, points: tuple[tuple[float, float], ...]) -> Lane:
        return Lane(name, kind, points, 3.0, 3.0, False, ())

    lanes = (
        lane("l", "turn", left),
        lane("r", "turn", right),
        lane("a", "turn", ahead),
        lane("b", "road", left),
    )
    assert turns_of(lanes) == {"l": "left", "r": "right"}
