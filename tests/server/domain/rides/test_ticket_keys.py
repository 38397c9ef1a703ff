"""Links and boarding codes are derived from a key and an id; without the key none can be made or checked."""

import re

import pytest

from server.api.formats import TOKEN_PATTERN
from server.domain.errors import TicketKeyMissing
from server.domain.rides.ticket_keys import TicketKeys, subject_of

OLD, NEW = bytes(range(32)), bytes(range(1, 33))
KEYS = TicketKeys([NEW, OLD])
NEW_ID, OLD_ID = KEYS.ids


def test_the_same_key_and_ride_give_the_same_secrets_on_every_server() -> None:
    other_server = TicketKeys([OLD])
    assert KEYS.ride_secrets(OLD_ID, "ride-1") == other_server.ride_secrets(OLD_ID, "ride-1")
    assert KEYS.series_token(OLD_ID, "series-1") == other_server.series_token(OLD_ID, "series-1")


def test_another_key_ride_or_kind_gives_another_token() -> None:
    tokens = {
        KEYS.ride_secrets(NEW_ID, "ride-1").token[:24],
        KEYS.ride_secrets(OLD_ID, "ride-1").token[:24],
        KEYS.ride_secrets(NEW_ID, "ride-2").token[:24],
        KEYS.series_token(NEW_ID, "ride-1")[:24],
    }
    assert len(tokens) == 4


def test_a_token_names_its_ride_and_fits_into_a_link() -> None:
    token = KEYS.ride_secrets(NEW_ID, "ride-5f2c").token
    assert subject_of(token) == "ride-5f2c"
    assert re.fullmatch(TOKEN_PATTERN, token)


def test_a_token_is_proof_of_its_own_ride_alone() -> None:
    token = KEYS.ride_secrets(NEW_ID, "ride-1").token
    assert KEYS.proves_ride(token, NEW_ID, "ride-1")
    assert not KEYS.proves_ride(token, OLD_ID, "ride-1")
    assert not KEYS.proves_ride(token, NEW_ID, "ride-2")
    assert not KEYS.proves_series(token, NEW_ID, "ride-1")
    assert not KEYS.proves_ride("A" + token[1:], NEW_ID, "ride-1")
    assert not KEYS.proves_ride("", NEW_ID, "ride-1")


def test_boarding_codes_have_four_digits_and_differ() -> None:
    codes = [KEYS.ride_secrets(NEW_ID, f"ride-{n}").boarding_code for n in range(200)]
    assert all(re.fullmatch(r"\d{4}", code) for code in codes)
    assert len(set(codes)) > 190


@pytest.mark.parametrize("key_id", ["", "erased"])
def test_a_ride_without_a_key_has_no_secrets_and_no_proof(key_id: str) -> None:
    secrets = KEYS.ride_secrets(key_id, "ride-1")
    assert (secrets.token, secrets.boarding_code, KEYS.series_token(key_id, "series-1")) == ("", "", "")
    assert not KEYS.proves_ride("", key_id, "ride-1")
    assert not KEYS.proves_series("", key_id, "series-1")


def test_a_process_without_keys_makes_no_links() -> None:
    with pytest.raises(TicketKeyMissing):
        _ = TicketKeys(()).newest_id


def test_no_repr_shows_a_secret() -> None:
    secrets = KEYS.ride_secrets(NEW_ID, "ride-1")
    shown = f"{secrets!r} {KEYS!r}"
    assert secrets.token not in shown
    assert secrets.boarding_code not in shown
    assert repr(NEW) not in shown
