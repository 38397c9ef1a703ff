"""What is spoken: one sentence at a time, warnings first, each once for its occasion."""

import msgspec

from vehicle_agent.hmi import texts
from vehicle_agent.hmi.texts import Words

# Who waits longer in the queue than others: a warning is spoken before news, news before talk.
TALK, NEWS, WARNING = range(3)
_QUEUE_MAX = 4


class Utterance(msgspec.Struct, frozen=True):
    """Something to say, not after until_ns. kind: what it is about; key: which occasion of that kind."""

    kind: str
    key: str
    said: Words
    rank: int
    until_ns: int


class SpeechState(msgspec.Struct, frozen=True):
    """occasions: (kind, key) of the last one of each kind, spoken of or not; queue: still to be said.

    quiet_ns: until then the last sentence is being spoken.
    """

    occasions: tuple[tuple[str, str], ...] = ()
    queue: tuple[Utterance, ...] = ()
    quiet_ns: int = 0

    def with_occasion(self, kind: str, key: str, said: Words, rank: int, until_ns: int) -> "SpeechState":
        """Queued, unless this is the occasion of that kind which was there last.

        A newer occasion takes the place of an older one of its kind that still waits. When the queue is
        full, what matters least is left out.
        """
        known = dict(self.occasions)
        if known.get(kind) == key:
            return self
        known[kind] = key
        waiting = [sentence for sentence in self.queue if sentence.kind != kind]
        waiting.append(Utterance(kind, key, said, rank, until_ns))
        waiting.sort(key=lambda sentence: -sentence.rank)
        return msgspec.structs.replace(
            self, occasions=tuple(known.items()), queue=tuple(waiting[:_QUEUE_MAX])
        )

    def without(self, kind: str) -> "SpeechState":
        """What waits of this kind is no longer true."""
        if not any(sentence.kind == kind for sentence in self.queue):
            return self
        return msgspec.structs.replace(self, queue=tuple(s for s in self.queue if s.kind != kind))

    def spoken(self, gap_ns: int, now_ns: int) -> tuple[Utterance | None, "SpeechState"]:
        """The sentence to begin now, if any."""
        queue = tuple(sentence for sentence in self.queue if sentence.until_ns >= now_ns)
        if not queue or now_ns < self.quiet_ns:
            return None, msgspec.structs.replace(self, queue=queue)
        quiet_ns = now_ns + max(gap_ns, duration_ns(queue[0].said))
        return queue[0], msgspec.structs.replace(self, queue=queue[1:], quiet_ns=quiet_ns)


def duration_ns(said: Words) -> int:
    """About how long both languages take to speak: 14 letters or 4.5 characters a second, and a breath."""
    english, chinese = said
    seconds = 0.3 + len(english) / 14.0 + (len(chinese) / 4.5 if chinese != english else 0.0)
    return round(seconds * 1e9) if said != texts.NOTHING else 0
