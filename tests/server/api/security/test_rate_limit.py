import pytest

from server.api.security.rate_limit import CLIENTS_MAX, RateLimit, TooManyTries

SECOND = 1_000_000_000


def test_tries_run_out_and_come_back_with_time() -> None:
    limit = RateLimit(6)
    for _ in range(6):
        limit.take("a", 0)
    with pytest.raises(TooManyTries) as refusal:
        limit.take("a", 0)
    assert refusal.value.retry_after_s == pytest.approx(10.0)
    limit.take("a", 10 * SECOND)
    with pytest.raises(TooManyTries) as refusal:
        limit.take("a", 14 * SECOND)
    assert refusal.value.retry_after_s == pytest.approx(6.0), "the next try is that much nearer already"


def test_one_client_does_not_use_up_the_tries_of_another() -> None:
    limit = RateLimit(1)
    limit.take("a", 0)
    limit.take("b", 0)
    with pytest.raises(TooManyTries):
        limit.take("a", 0)


def test_a_clock_that_goes_back_gives_nothing_for_free() -> None:
    limit = RateLimit(1)
    limit.take("a", 100 * SECOND)
    with pytest.raises(TooManyTries):
        limit.take("a", 0)


def test_no_flood_of_addresses_fills_the_memory() -> None:
    limit = RateLimit(1)
    for number in range(CLIENTS_MAX + 500):
        limit.take(str(number), 0)
    assert len(limit._buckets) == CLIENTS_MAX


def test_who_stays_away_for_a_day_has_saved_up_a_minute_s_tries_and_no_more() -> None:
    limit = RateLimit(6)
    limit.take("a", 0)
    for _ in range(6):
        limit.take("a", 86_400 * SECOND)
    with pytest.raises(TooManyTries, match="wait 10 s"):
        limit.take("a", 86_400 * SECOND)
