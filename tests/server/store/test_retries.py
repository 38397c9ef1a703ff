"""Pauses between attempts grow, differ by chance, and end."""

from server.store.writing.retries import FIRST_PAUSE_S, PATIENCE_S, PAUSE_S_MAX, Retries


class Waiting:
    """Time that passes only in pauses."""

    def __init__(self, chance: float) -> None:
        self.now_s = 100.0
        self.pauses_s: list[float] = []
        self.retries = Retries(
            pause=self.pause, chance=lambda: chance, monotonic_s=lambda: self.now_s, patience_s=PATIENCE_S
        )

    def pause(self, seconds: float) -> bool:
        self.pauses_s.append(seconds)
        self.now_s += seconds
        return True

    def wait_until_over(self) -> list[float]:
        patience = self.retries.begin()
        for _ in range(1000):
            if not patience.wait():
                return self.pauses_s
        raise AssertionError("the patience never ends")


def test_pauses_double_up_to_the_longest_and_end_with_the_patience() -> None:
    pauses_s = Waiting(chance=1.0).wait_until_over()
    assert pauses_s[:5] == [FIRST_PAUSE_S * 2**k for k in range(5)]
    assert max(pauses_s) == PAUSE_S_MAX
    assert abs(sum(pauses_s) - PATIENCE_S) < 1e-6


def test_half_of_a_pause_is_chance() -> None:
    assert Waiting(chance=0.0).wait_until_over()[0] == FIRST_PAUSE_S / 2.0


def test_nothing_is_tried_again_when_the_pause_is_ended_from_outside() -> None:
    assert not Retries(pause=lambda _: False).begin().wait()
