"""Texts on screens, signals and announcements, for people outside and inside.

GEM, section VII; Snow Lion, rear LED and sound player.
"""

import msgspec

from vehicle_agent.hmi import texts
from vehicle_agent.hmi.attention import Attention, WatchedPerson
from vehicle_agent.hmi.signalling import SignallingState, VehicleSignalling
from vehicle_agent.hmi.signs import DisplayState, is_arriving, sign_for
from vehicle_agent.hmi.speech import COURTESY, NEWS, WARNING, SpeechState
from vehicle_agent.hmi.texts import BilingualText
from vehicle_agent.hmi.yielding import YieldingState, update_yielding
from vehicle_agent.signals import GuardStatus, HmiOutput, Path, Task, World

_Occasion = tuple[str, str, BilingualText, int]


class HmiState(msgspec.Struct, frozen=True):
    """What the room remembers.

    tracks_ns           stamp of the tracks that were processed last
    aside_chosen_ns     when a person was last asked to step aside, 0 never
    courtesy_chosen_ns  when the last courtesy ("after you", "passing") was chosen, 0 never
    doors_ns            when the doors last changed, 0 never
    """

    display: DisplayState = DisplayState()
    speech: SpeechState = SpeechState()
    yielding: YieldingState = YieldingState()
    watched: tuple[WatchedPerson, ...] = ()
    tracks_ns: int = 0
    aside_chosen_ns: int = 0
    courtesy_chosen_ns: int = 0
    announced_ns: int = 0
    doors_open: bool = False
    doors_ns: int = 0
    signalling: SignallingState = SignallingState()


class Announcer(msgspec.Struct, frozen=True):
    """signalling  turn signals, headlights and horn
    show_ns     a text stays this long, unless a warning replaces it
    hysteresis_ns  yielding and passing end when they have been over for this long
    step_aside_ns  a person for whom the vehicle has stood this long is asked to step aside
    aside_again_ns  shortest time between two such sentences
    courtesy_ns    shortest time between two courtesies to people outside (after you, passing)
    settle_ns      standing or passing lasts this long before it is announced
    gap_ns         shortest time between the beginnings of two sentences; a long one takes its own time
    wait_ns_max    a sentence that cannot begin within this time is dropped
    stopping_m     a stop is announced this far before it
    """

    attention: Attention
    signalling: VehicleSignalling = VehicleSignalling()
    show_ns: int = 1_500_000_000
    hysteresis_ns: int = 1_000_000_000
    step_aside_ns: int = 10_000_000_000
    aside_again_ns: int = 10_000_000_000
    courtesy_ns: int = 30_000_000_000
    settle_ns: int = 1_500_000_000
    gap_ns: int = 3_000_000_000
    wait_ns_max: int = 12_000_000_000
    stopping_m: float = 20.0

    def initial(self) -> HmiState:
        return HmiState()

    def step(
        self, state: HmiState, task: Task, path: Path, world: World, guard_status: GuardStatus, now_ns: int
    ) -> tuple[HmiOutput, HmiState]:
        """The screens and signals now, and at most one sentence that begins in this tick."""
        yielding = update_yielding(state.yielding, task, path, guard_status, self.hysteresis_ns, now_ns)
        state = msgspec.structs.replace(state, yielding=yielding)
        driving = guard_status.mode == "autonomous" and task.mode == "drive"
        state = self._with_watched(state, task, path, world, driving, now_ns)
        blocked = yielding.stands and now_ns - yielding.stood_ns >= self.step_aside_ns
        unaware = driving and bool(self.attention.unaware(state.watched, now_ns))
        sign = sign_for(task, path, guard_status, yielding, blocked or unaware, self.stopping_m)
        state = msgspec.structs.replace(state, display=state.display.with_sign(sign, self.show_ns, now_ns))
        if task.doors_open != state.doors_open:
            state = msgspec.structs.replace(state, doors_open=task.doors_open, doors_ns=now_ns)
        state = self._with_requests(state, blocked, driving, now_ns)
        speech = state.speech
        if not (blocked or unaware):
            speech = speech.without("step aside")
        if not (yielding.stands or yielding.passes):
            speech = speech.without("after you")
        for kind, key, text, rank in self._occasions(state, task, path, guard_status):
            speech = speech.with_occasion(kind, key, text, rank, now_ns + self.wait_ns_max)
        sentence, speech = speech.next_sentence(self.gap_ns, now_ns)
        state = msgspec.structs.replace(
            state, speech=speech, announced_ns=max(state.announced_ns, task.announced_ns)
        )
        sign, text = state.display.sign, texts.NO_TEXT if sentence is None else sentence.text
        signals, signalling = self.signalling.step(state.signalling, task, path, guard_status, now_ns)
        state = msgspec.structs.replace(state, signalling=signalling)
        return HmiOutput(*sign.front, *text, task.doors_open, *sign.rear, signals), state

    def _with_watched(
        self, state: HmiState, task: Task, path: Path, world: World, driving: bool, now_ns: int
    ) -> HmiState:
        """With the people watched: new tracks are processed once, and only while the vehicle drives."""
        if not driving:
            return msgspec.structs.replace(state, watched=(), tracks_ns=world.tracks.stamp_ns)
        if world.tracks.stamp_ns == state.tracks_ns:
            return state
        watched = self.attention.update(state.watched, task, path, world, now_ns)
        return msgspec.structs.replace(state, watched=watched, tracks_ns=world.tracks.stamp_ns)

    def _with_requests(self, state: HmiState, blocked: bool, driving: bool, now_ns: int) -> HmiState:
        """With a request or a courtesy to people outside, if one is due; its time identifies the occasion."""
        yielding = state.yielding
        unasked = driving and bool(self.attention.unasked(state.watched, now_ns))
        is_newly_blocked = blocked and state.aside_chosen_ns < yielding.stood_ns
        if (unasked or is_newly_blocked) and _is_due(state.aside_chosen_ns, self.aside_again_ns, now_ns):
            watched = self.attention.with_asked(state.watched, now_ns)
            return msgspec.structs.replace(state, watched=watched, aside_chosen_ns=now_ns)
        if not driving or not _is_due(state.courtesy_chosen_ns, self.courtesy_ns, now_ns):
            return state
        since_ns = yielding.stood_ns or (0 if yielding.yields else yielding.passing_ns)
        if since_ns and now_ns - since_ns >= self.settle_ns:
            return msgspec.structs.replace(state, courtesy_chosen_ns=now_ns)
        return state

    def _occasions(
        self, state: HmiState, task: Task, path: Path, guard_status: GuardStatus
    ) -> list[_Occasion]:
        """The occasions for a sentence now: (kind, key, text, rank)."""
        occasions: list[_Occasion] = []
        if task.announced_ns > state.announced_ns and task.announcement:
            text = (task.announcement, task.announcement_zh or task.announcement)
            occasions.append(("operator", str(task.announced_ns), text, NEWS))
        if guard_status.mode in ("minimal_risk", "fault"):
            occasions.append(("safety stop", str(task.resumed_ns), texts.SAY_SAFETY_STOP, WARNING))
        elif guard_status.mode == "held" and task.aboard:
            occasions.append(("held", str(task.resumed_ns), texts.SAY_HELD, NEWS))
        if task.refused_ns:
            occasions.append(("refused", str(task.refused_ns), texts.SAY_REFUSED, NEWS))
        if state.doors_ns:
            text = texts.SAY_DOORS_OPEN if state.doors_open else texts.SAY_DOORS_CLOSING
            occasions.append(("doors", str(state.doors_ns), text, WARNING))
        if state.aside_chosen_ns:
            occasions.append(("step aside", str(state.aside_chosen_ns), texts.SAY_STEP_ASIDE, WARNING))
        if state.courtesy_chosen_ns:
            text = texts.SAY_AFTER_YOU if state.yielding.stands else texts.SAY_PASSING
            occasions.append(("after you", str(state.courtesy_chosen_ns), text, COURTESY))
        if task.mode == "drive" and guard_status.mode == "autonomous":
            occasions += self._on_the_way(task, path)
        return occasions

    def _on_the_way(self, task: Task, path: Path) -> list[_Occasion]:
        if task.reason == "requested_stop":
            return [("requested", task.visit_id, texts.SAY_REQUESTED, NEWS)]
        if not (task.stop_name or task.stop_name_en):
            return []
        names = (task.stop_name, task.stop_name_en)
        if is_arriving(task, path, self.stopping_m):
            return [("arriving", task.visit_id, texts.say_stopping_at(*names), NEWS)]
        return [("next", task.visit_id, texts.say_next_stop(*names), NEWS)]


def _is_due(last_ns: int, interval_ns: int, now_ns: int) -> bool:
    return not last_ns or now_ns - last_ns >= interval_ns
