"""How long a failed task waits before it is tried again, and how often it may fail."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class RetryPolicy:
    """Growing pauses (exponential backoff) with jitter, so that several replicas do not retry together.

    first_s       the pause after the first failure
    factor        by which each further pause is longer
    pause_s_max   no pause is longer
    jitter_ratio  each pause is shortened at random by up to this share
    failures_max  so many failures in a row end the process
    """

    first_s: float = 0.5
    factor: float = 2.0
    pause_s_max: float = 10.0
    jitter_ratio: float = 0.25
    failures_max: int = 12

    def pause_s(self, failures: int, chance: float) -> float:
        """The pause after so many failures in a row; chance: uniform in [0, 1)."""
        # The exponent is bounded: a float has no room for the thousandth doubling.
        grown_s = self.first_s * self.factor ** min(failures - 1, 64)
        return min(grown_s, self.pause_s_max) * (1.0 - self.jitter_ratio * chance)


# In virtual time an unexpected failure is a defect, and the run ends with it.
FAIL_AT_ONCE = RetryPolicy(failures_max=1)
