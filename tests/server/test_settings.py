from pathlib import Path

import pytest

from server.settings import SettingsError, settings_from


def test_without_an_environment_the_server_listens_on_this_machine_only() -> None:
    settings = settings_from({})
    assert settings.is_loopback()
    assert settings.database() == "sqlite:///var/campusloop.db"
    assert settings.origin() == "http://127.0.0.1:8080"


def test_options_win_over_the_environment_and_none_means_not_given() -> None:
    environment = {"CAMPUSLOOP_PORT": "9000", "CAMPUSLOOP_HOST": "::1"}
    settings = settings_from(environment, port=9001, host=None)
    assert (settings.port, settings.host) == (9001, "::1")
    assert settings.origin() == "http://[::1]:9001"


@pytest.mark.parametrize(
    ("name", "value"),
    [("PORT", "many"), ("PORT", "70000"), ("SERVICE_OPENS", "8 o'clock"), ("SESSION_HOURS", "0")],
)
def test_a_setting_that_cannot_be_used_is_named(name: str, value: str) -> None:
    with pytest.raises(SettingsError, match=f"CAMPUSLOOP_{name}"):
        settings_from({f"CAMPUSLOOP_{name}": value})


def test_a_certificate_without_its_key_is_refused() -> None:
    with pytest.raises(SettingsError, match="both or neither"):
        settings_from({}, tls_cert=Path("cert.pem"))


@pytest.mark.parametrize(("host", "expected"), [("127.0.0.2", True), ("localhost", True), ("0.0.0.0", False)])
def test_loopback_is_told_from_the_rest(host: str, expected: bool) -> None:
    assert settings_from({}, host=host).is_loopback() is expected
