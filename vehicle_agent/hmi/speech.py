"""The loudspeaker's queue: one sentence at a time, warnings first, each once for its occasion."""

import msgspec

from vehicle_agent.hmi import texts
from vehicle_agent.hmi.texts import BilingualText

# Ranks: a warning is spoken before news, news before a courtesy.
COURTESY, NEWS, WARNING = range(3)
_QUEUE_MAX = 4


class Utterance(msgspec.Struct, frozen=True):
    """A sentence to speak before expires_ns. kind: its subject; key: the occasion of that kind."""

    kind: str
    key: str
    text: BilingualText
    rank: int
    expires_ns: int


class SpeechState(msgspec.Struct, frozen=True):
    """occasions: (kind, key) of the last occasion of each kind, spoken or not; queue: still to be spoken.

    busy_until_ns: the last sentence is being spoken until then.
    """

    occasions: tuple[tuple[str, str], ...] = ()
    queue: tuple[Utterance, ...] = ()
    busy_until_ns: int = 0

    def with_occasion(
        self, kind: str, key: str, text: BilingualText, rank: int, expires_ns: int
    ) -> "SpeechState":
        """The state with a sentence queued, unless this is the last occasion of its kind.

        A newer occasion replaces an older one of its kind in the queue. When the queue is full, the sentences
        of the lowest rank are dropped.
        """
        latest = dict(self.occasions)
        if latest.get(kind) == key:
            return self
        latest[kind] = key
        queue = [sentence for sentence in self.queue if sentence.kind != kind]
        queue.append(Utterance(kind, key, text, rank, expires_ns))
        queue.sort(key=lambda sentence: -sentence.rank)
        return msgspec.structs.replace(self, occasions=tuple(latest.items()), queue=tuple(queue[:_QUEUE_MAX]))

    def without(self, kind: str) -> "SpeechState":
        """The state without queued sentences of this kind: they are no longer true."""
        if not any(sentence.kind == kind for sentence in self.queue):
            return self
        return msgspec.structs.replace(self, queue=tuple(s for s in self.queue if s.kind != kind))

    def next_sentence(self, gap_ns: int, now_ns: int) -> tuple[Utterance | None, "SpeechState"]:
        """(the sentence to begin now, if any; the state)."""
        queue = tuple(sentence for sentence in self.queue if sentence.expires_ns >= now_ns)
        if not queue or now_ns < self.busy_until_ns:
            return None, msgspec.structs.replace(self, queue=queue)
        busy_until_ns = now_ns + max(gap_ns, duration_ns(queue[0].text))
        return queue[0], msgspec.structs.replace(self, queue=queue[1:], busy_until_ns=busy_until_ns)


def duration_ns(text: BilingualText) -> int:
    """Time to speak both languages, about: 14 letters or 4.5 Chinese characters a second, and a pause."""
    english, chinese = text
    seconds = 0.3 + len(english) / 14.0 + (len(chinese) / 4.5 if chinese != english else 0.0)
    return round(seconds * 1e9) if text != texts.NO_TEXT else 0
