"""Talking to people outside and inside (GEM, section VII; Snow Lion, rear LED and sound player): texts on the
screens, and sentences."""

import msgspec

from vehicle_agent.hmi import texts
from vehicle_agent.hmi.attention import Attention, WatchedPerson
from vehicle_agent.hmi.signs import DisplayState, is_arriving, sign_for
from vehicle_agent.hmi.speech import NEWS, TALK, WARNING, SpeechState
from vehicle_agent.hmi.texts import Words
from vehicle_agent.hmi.yielding import YieldingState, manner_now
from vehicle_agent.signals import GuardStatus, HmiOutput, Path, Task, World

_Occasion = tuple[str, str, Words, int]


class HmiState(msgspec.Struct, frozen=True):
    """What the room remembers.

    tracks_ns    of the tracks that were last looked at
    aside_ns     when somebody was last asked to step aside, 0 never
    talked_ns    when people outside were last addressed in passing or waiting, 0 never
    """

    board: DisplayState = DisplayState()
    speech: SpeechState = SpeechState()
    manner: YieldingState = YieldingState()
    watched: tuple[WatchedPerson, ...] = ()
    tracks_ns: int = 0
    aside_ns: int = 0
    talked_ns: int = 0
    announced_ns: int = 0
    doors_open: bool = False
    doors_ns: int = 0


class Announcer(msgspec.Struct, frozen=True):
    """show_ns     a text stays this long, unless a warning replaces it
    calm_ns        yielding and passing last until they have not been so for this long
    step_aside_ns  after standing so long for somebody, whoever it is is asked to step aside
    aside_again_ns nobody is asked to within this time of the last such sentence
    talk_ns        polite words to people outside (after you, passing) are so far apart
    settle_ns      standing or passing lasts so long before anything is said about it
    gap_ns         at least, between the beginnings of two sentences; a long one takes its own time
    patience_ns    what could not be said within this time is not said
    stopping_m     before a stop, it is announced
    """

    attention: Attention = Attention()
    show_ns: int = 1_500_000_000
    calm_ns: int = 1_000_000_000
    step_aside_ns: int = 10_000_000_000
    aside_again_ns: int = 10_000_000_000
    talk_ns: int = 30_000_000_000
    settle_ns: int = 1_500_000_000
    gap_ns: int = 3_000_000_000
    patience_ns: int = 12_000_000_000
    stopping_m: float = 20.0

    def initial(self) -> HmiState:
        return HmiState()

    def step(
        self, state: HmiState, task: Task, path: Path, world: World, verdict: GuardStatus, now_ns: int
    ) -> tuple[HmiOutput, HmiState]:
        """The screens now, and at most one sentence to begin to speak in this very tick."""
        manner = manner_now(state.manner, task, path, verdict, self.calm_ns, now_ns)
        state = msgspec.structs.replace(state, manner=manner)
        driving = verdict.mode == "autonomous" and task.mode == "drive"
        state = self._watched(state, task, path, world, driving, now_ns)
        blocked = manner.stands and now_ns - manner.stood_ns >= self.step_aside_ns
        unaware = driving and bool(self.attention.unaware(state.watched, now_ns))
        wanted = sign_for(task, path, verdict, manner, blocked or unaware, self.stopping_m)
        state = msgspec.structs.replace(state, board=state.board.turned_to(wanted, self.show_ns, now_ns))
        if task.doors_open != state.doors_open:
            state = msgspec.structs.replace(state, doors_open=task.doors_open, doors_ns=now_ns)
        state = self._asking(state, blocked, driving, now_ns)
        speech = state.speech
        if not (blocked or unaware):
            speech = speech.without("step aside")
        if not (manner.stands or manner.passes):
            speech = speech.without("after you")
        for kind, key, said, rank in self._occasions(state, task, path, verdict):
            speech = speech.with_occasion(kind, key, said, rank, now_ns + self.patience_ns)
        sentence, speech = speech.spoken(self.gap_ns, now_ns)
        state = msgspec.structs.replace(
            state, speech=speech, announced_ns=max(state.announced_ns, task.announced_ns)
        )
        sign, said = state.board.sign, texts.NOTHING if sentence is None else sentence.said
        return HmiOutput(*sign.front, *said, task.doors_open, *sign.rear), state

    def _watched(
        self, state: HmiState, task: Task, path: Path, world: World, driving: bool, now_ns: int
    ) -> HmiState:
        """Tracks are looked at once; whoever is in the way of a vehicle that is not under way is not."""
        if not driving:
            return msgspec.structs.replace(state, watched=(), tracks_ns=world.tracks.stamp_ns)
        if world.tracks.stamp_ns == state.tracks_ns:
            return state
        watched = self.attention.watch(state.watched, task, path, world, now_ns)
        return msgspec.structs.replace(state, watched=watched, tracks_ns=world.tracks.stamp_ns)

    def _asking(self, state: HmiState, blocked: bool, driving: bool, now_ns: int) -> HmiState:
        """Decides on sentences to people outside; the occasion of each is the moment decided on."""
        manner = state.manner
        unasked = driving and bool(self.attention.unasked(state.watched, now_ns))
        first_block = blocked and state.aside_ns < manner.stood_ns
        if (unasked or first_block) and _apart(state.aside_ns, self.aside_again_ns, now_ns):
            watched = self.attention.asked(state.watched, now_ns)
            return msgspec.structs.replace(state, watched=watched, aside_ns=now_ns)
        if not driving or not _apart(state.talked_ns, self.talk_ns, now_ns):
            return state
        begun_ns = manner.stood_ns or (0 if manner.yields else manner.passing_ns)
        if begun_ns and now_ns - begun_ns >= self.settle_ns:
            return msgspec.structs.replace(state, talked_ns=now_ns)
        return state

    def _occasions(self, state: HmiState, task: Task, path: Path, verdict: GuardStatus) -> list[_Occasion]:
        """What there is to say now, by kind and occasion."""
        found: list[_Occasion] = []
        if task.announced_ns > state.announced_ns and task.announcement:
            said = (task.announcement, task.announcement)
            found.append(("operator", str(task.announced_ns), said, NEWS))
        if verdict.mode in ("minimal_risk", "fault"):
            found.append(("safety stop", str(task.resumed_ns), texts.SAY_SAFETY_STOP, WARNING))
        elif verdict.mode == "held" and task.aboard:
            found.append(("held", str(task.resumed_ns), texts.SAY_HELD, NEWS))
        if task.refused_ns:
            found.append(("refused", str(task.refused_ns), texts.SAY_REFUSED, NEWS))
        if state.doors_ns:
            said = texts.SAY_DOORS_OPEN if state.doors_open else texts.SAY_DOORS_CLOSING
            found.append(("doors", str(state.doors_ns), said, WARNING))
        if state.aside_ns:
            found.append(("step aside", str(state.aside_ns), texts.SAY_STEP_ASIDE, WARNING))
        if state.talked_ns:
            said = texts.SAY_AFTER_YOU if state.manner.stands else texts.SAY_PASSING
            found.append(("after you", str(state.talked_ns), said, TALK))
        if task.mode == "drive" and verdict.mode == "autonomous":
            found += self._on_the_way(task, path)
        return found

    def _on_the_way(self, task: Task, path: Path) -> list[_Occasion]:
        if task.reason == "requested_stop":
            return [("requested", task.visit_id, texts.SAY_REQUESTED, NEWS)]
        if not (task.stop_name or task.stop_name_en):
            return []
        names = (task.stop_name, task.stop_name_en)
        if is_arriving(task, path, self.stopping_m):
            return [("arriving", task.visit_id, texts.say_stopping_at(*names), NEWS)]
        return [("next", task.visit_id, texts.say_next_stop(*names), NEWS)]


def _apart(last_ns: int, least_ns: int, now_ns: int) -> bool:
    return not last_ns or now_ns - last_ns >= least_ns
