"""Screen and voice: the right words, each once, without flicker."""

import itertools
from typing import Any

import msgspec
import numpy as np

from vehicle_agent.config import Profile
from vehicle_agent.hmi import texts
from vehicle_agent.signals import GuardStatus, HmiOutput, Path, Task, World
from vehicle_agent.stacks.rooms import announcer

TICK_NS = 20_000_000
TASK = Task(
    "drive",
    None,
    1,
    0.0,
    0.0,
    90.0,
    "l",
    0.0,
    "o",
    1,
    "v1",
    "图书馆",
    "Library",
    False,
    (),
    "",
    None,
    resumed_ns=1,
)
PATH = Path(0, np.empty((0, 2)), np.empty(0), 3.0, "waypoint_speed", None, 90.0, False)


WORLD = World(0, 0, np.empty((0, 2)), (), (), False)


class Street:
    """An announcer and what it has said so far."""

    def __init__(self) -> None:
        self.room, self.now_ns = announcer(Profile()), 0
        self.state = self.room.initial()
        self.spoken: list[tuple[str, str]] = []

    def run(
        self, seconds: float, mode: str = "autonomous", limited_by: str = "waypoint_speed", **task: Any
    ) -> HmiOutput:
        path = msgspec.structs.replace(PATH, limited_by=limited_by, stop_m=task.pop("stop_m", 90.0))
        if limited_by == "obstacle":
            path = msgspec.structs.replace(path, speed_mps=0.0)
        for _ in range(round(seconds * 50)):
            self.now_ns += TICK_NS
            verdict = GuardStatus(mode, "", ())  # type: ignore[arg-type]
            says, self.state = self.room.step(
                self.state, msgspec.structs.replace(TASK, **task), path, WORLD, verdict, self.now_ns
            )
            if says.announce:
                self.spoken.append((says.announce, says.announce_zh))
        return says


def test_the_next_stop_is_shown_and_said_once_in_both_languages() -> None:
    street = Street()
    says = street.run(20)
    assert (says.screen, says.screen_zh) == ("NEXT STOP LIBRARY", "下一站 图书馆")
    assert street.spoken == [("Next stop: Library.", "下一站：图书馆。")]


def test_a_stop_is_announced_when_it_is_near() -> None:
    street = Street()
    street.run(10)
    assert street.run(5, stop_m=10.0).screen == "STOPPING AT LIBRARY"
    assert street.spoken[-1] == texts.say_stopping_at("图书馆", "Library")


def test_the_vehicle_lets_people_go_first_and_asks_them_after_ten_seconds() -> None:
    street = Street()
    street.run(5)
    assert street.run(9.5, limited_by="obstacle").screen == texts.AFTER_YOU[0]
    assert texts.SAY_STEP_ASIDE not in street.spoken
    assert street.run(20, limited_by="obstacle").screen == texts.STEP_ASIDE[0]
    assert street.spoken.count(texts.SAY_STEP_ASIDE) == 1


def test_the_screen_does_not_flicker() -> None:
    street, shown = Street(), []
    for k in range(100):
        shown.append(street.run(0.02, limited_by="passing" if k % 2 else "waypoint_speed").screen)
    changes = sum(a != b for a, b in itertools.pairwise(shown))
    assert changes <= 2


def test_doors_are_announced_when_they_open_and_when_they_close() -> None:
    street = Street()
    assert street.run(6, mode="autonomous", doors_open=True).screen == texts.DOORS_OPEN[0]
    assert street.run(6, doors_open=False).doors_open is False
    doors = [said for said in street.spoken if said in (texts.SAY_DOORS_OPEN, texts.SAY_DOORS_CLOSING)]
    assert doors == [texts.SAY_DOORS_OPEN, texts.SAY_DOORS_CLOSING]


def test_a_safety_stop_outranks_everything() -> None:
    street = Street()
    says = street.run(5, mode="minimal_risk", limited_by="obstacle")
    assert says.screen == texts.SAFETY_STOP[0]
    assert street.spoken == [texts.SAY_SAFETY_STOP]


def test_the_operators_words_are_spoken_once() -> None:
    street = Street()
    street.run(10, announcement="Lunch is ready.", announced_ns=5)
    assert street.spoken.count(("Lunch is ready.", "Lunch is ready.")) == 1


def test_the_operators_words_are_spoken_in_both_languages() -> None:
    street = Street()
    street.run(10, announcement="Lunch is ready.", announcement_zh="午饭好了。", announced_ns=5)
    assert ("Lunch is ready.", "午饭好了。") in street.spoken


def test_a_seat_button_that_is_refused_is_answered_once_for_each_press() -> None:
    street = Street()
    street.run(10, refused_ns=5)
    street.run(10, refused_ns=9_000_000_000)
    assert street.spoken.count(texts.SAY_REFUSED) == 2


def test_sentences_do_not_run_into_each_other() -> None:
    street, times = Street(), []
    for _ in range(500):
        before = len(street.spoken)
        street.run(0.02, announcement="Hello.", announced_ns=5, doors_open=street.now_ns > 10**9)
        if len(street.spoken) > before:
            times.append(street.now_ns)
    assert len(times) >= 2
    assert min(b - a for a, b in itertools.pairwise(times)) >= street.room.gap_ns


def test_manual_driving_and_a_hold_are_shown() -> None:
    assert Street().run(2, mode="manual").screen == texts.MANUAL[0]
    assert Street().run(2, mode="held").screen == texts.HELD[0]
