"""Instants as numbers: exact, and back."""

from datetime import UTC, datetime, timedelta, timezone

from hypothesis import given
from hypothesis import strategies as st

from server.domain.instants import EPOCH, ms_of, ns_of

_LATEST_US = 4_000_000_000_000_000
MOMENTS = st.integers(0, _LATEST_US).map(lambda us: EPOCH + timedelta(microseconds=us))


@given(moment=MOMENTS)
def test_an_instant_on_the_wire_is_exact_to_the_microsecond(moment: datetime) -> None:
    assert EPOCH + timedelta(microseconds=ns_of(moment) / 1000) == moment
    assert ns_of(moment) % 1000 == 0


@given(moment=MOMENTS)
def test_a_page_gets_whole_milliseconds_and_nought_for_no_moment(moment: datetime) -> None:
    assert timedelta() <= moment - EPOCH - timedelta(milliseconds=ms_of(moment)) < timedelta(milliseconds=1)
    assert ms_of(None) == 0


def test_the_same_instant_has_the_same_number_in_every_time_zone() -> None:
    utc = datetime(2026, 11, 23, 4, 0, tzinfo=UTC)
    shanghai = utc.astimezone(timezone(timedelta(hours=8)))
    assert (ns_of(shanghai), ms_of(shanghai)) == (ns_of(utc), ms_of(utc))
