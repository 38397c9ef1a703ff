"""Talking to people outside and inside (GEM, section VII): one screen text at a time, each sentence once."""

import msgspec

from vehicle_agent.hmi import words
from vehicle_agent.hmi.words import Words
from vehicle_agent.signals import Guarded, Path, Says, Task

_NOTHING: Words = ("", "")


class Sentence(msgspec.Struct, frozen=True):
    """Something to say, not after until_ns; `about` names the occasion, so that it is said once."""

    about: str
    english: str
    chinese: str
    until_ns: int


class Speech(msgspec.Struct, frozen=True):
    """What is on the screen since when, what was said about, and what is still to be said.

    yielding_ns: standing for somebody since, 0 if not
    """

    screen: Words = _NOTHING
    screen_ns: int = 0
    yielding_ns: int = 0
    said: tuple[str, ...] = ()
    queue: tuple[Sentence, ...] = ()
    spoken_ns: int = 0
    announced_ns: int = 0
    doors_open: bool = False


class Announcer(msgspec.Struct, frozen=True):
    """show_ns: a text stays this long, unless somebody must be warned; gap_ns between two sentences."""

    show_ns: int = 1_000_000_000
    step_aside_ns: int = 10_000_000_000
    gap_ns: int = 3_000_000_000
    patience_ns: int = 8_000_000_000
    stopping_m: float = 20.0

    def initial(self) -> Speech:
        return Speech()

    def step(
        self, state: Speech, task: Task, path: Path, verdict: Guarded, now_ns: int
    ) -> tuple[Says, Speech]:
        """The screen now, and at most one sentence to begin to speak in this very tick."""
        yields = verdict.mode == "autonomous" and task.mode == "drive" and path.limited_by == "obstacle"
        stands = yields and path.speed_mps <= 0.0
        yielding_ns = (state.yielding_ns or now_ns) if stands else 0
        blocked = stands and now_ns - yielding_ns >= self.step_aside_ns
        wanted, urgent = self._screen(task, path, verdict, yields, stands, blocked)
        screen, screen_ns = state.screen, state.screen_ns
        if wanted != screen and (urgent or not screen_ns or now_ns - screen_ns >= self.show_ns):
            screen, screen_ns = wanted, now_ns
        state = msgspec.structs.replace(state, screen=screen, screen_ns=screen_ns, yielding_ns=yielding_ns)
        for about, said in self._occasions(state, task, path, verdict, blocked):
            state = self._queued(state, about, said, now_ns)
        state = msgspec.structs.replace(
            state, doors_open=task.doors_open, announced_ns=max(state.announced_ns, task.announced_ns)
        )
        spoken, state = self._spoken(state, now_ns)
        return Says(screen[0], screen[1], spoken[0], spoken[1], task.doors_open), state

    def _screen(
        self, task: Task, path: Path, verdict: Guarded, yields: bool, stands: bool, blocked: bool
    ) -> tuple[Words, bool]:
        """(the text for the outside, whether it may replace another at once)."""
        if verdict.mode == "manual":
            return words.MANUAL, True
        if verdict.mode in ("minimal_risk", "fault"):
            return words.SAFETY_STOP, True
        if task.doors_open:
            return words.DOORS_OPEN, True
        if verdict.mode == "held":
            return words.HELD, False
        if task.mode == "dwell":
            return words.DOORS_CLOSING, True
        if yields:
            return (words.STEP_ASIDE if blocked else words.AFTER_YOU if stands else words.SLOWING), stands
        if path.limited_by == "passing":
            return words.PASSING, False
        return self._way(task, path), False

    def _way(self, task: Task, path: Path) -> Words:
        if task.mode != "drive":
            return words.RESTING
        if task.waiting_for and path.stop_m < self.stopping_m:
            return words.WAITING
        if task.reason == "requested stop":
            return words.REQUESTED
        if not (task.stop_name or task.stop_name_en):
            return words.RESTING if path.speed_mps <= 0.0 else _NOTHING
        names = (task.stop_name, task.stop_name_en)
        near = path.stop_m < self.stopping_m and not task.waiting_for
        return words.stopping_at(*names) if near else words.next_stop(*names)

    def _occasions(
        self, state: Speech, task: Task, path: Path, verdict: Guarded, blocked: bool
    ) -> list[tuple[str, Words]]:
        """What there is to say now, by occasion."""
        found: list[tuple[str, Words]] = []
        if task.announced_ns > state.announced_ns and task.announcement:
            found.append((f"operator {task.announced_ns}", (task.announcement, task.announcement)))
        if verdict.mode in ("minimal_risk", "fault"):
            found.append((f"safety stop {task.resumed_ns}", words.SAY_SAFETY_STOP))
        elif verdict.mode == "held" and task.aboard:
            found.append((f"held {task.resumed_ns}", words.SAY_HELD))
        if task.refused_ns:
            found.append((f"refused {task.refused_ns}", words.SAY_REFUSED))
        if task.doors_open and not state.doors_open:
            found.append((f"doors open {task.visit_id}", words.SAY_DOORS_OPEN))
        if state.doors_open and not task.doors_open:
            found.append((f"doors closing {task.visit_id}", words.SAY_DOORS_CLOSING))
        if blocked:
            found.append((f"step aside {state.yielding_ns}", words.SAY_STEP_ASIDE))
        if task.mode == "drive" and verdict.mode == "autonomous":
            found += self._on_the_way(task, path)
        return found

    def _on_the_way(self, task: Task, path: Path) -> list[tuple[str, Words]]:
        if task.reason == "requested stop":
            return [(f"requested {task.visit_id}", words.SAY_REQUESTED)]
        if not (task.stop_name or task.stop_name_en):
            return []
        names = (task.stop_name, task.stop_name_en)
        if path.stop_m < self.stopping_m and not task.waiting_for:
            return [(f"arriving {task.visit_id}", words.say_stopping_at(*names))]
        return [(f"next {task.visit_id}", words.say_next_stop(*names))]

    def _queued(self, state: Speech, about: str, said: Words, now_ns: int) -> Speech:
        if about in state.said:
            return state
        sentence = Sentence(about, said[0], said[1], now_ns + self.patience_ns)
        return msgspec.structs.replace(
            state, said=(*state.said, about)[-32:], queue=(*state.queue, sentence)[-4:]
        )

    def _spoken(self, state: Speech, now_ns: int) -> tuple[Words, Speech]:
        queue = tuple(sentence for sentence in state.queue if sentence.until_ns >= now_ns)
        if not queue or (state.spoken_ns and now_ns - state.spoken_ns < self.gap_ns):
            return _NOTHING, msgspec.structs.replace(state, queue=queue)
        first = queue[0]
        return (first.english, first.chinese), msgspec.structs.replace(
            state, queue=queue[1:], spoken_ns=now_ns
        )
