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
    [
        ("PORT", "many"),
        ("PORT", "70000"),
        ("SERVICE_OPENS", "8 o'clock"),
        ("SESSION_HOURS", "0"),
        ("TRUSTED_PROXIES", "example.org"),
        ("ALLOWED_HOSTS", "http://a"),
    ],
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


def test_a_secret_can_lie_in_a_file(tmp_path: Path) -> None:
    (tmp_path / "password").write_text("correct horse\n")
    environment = {"CAMPUSLOOP_OPERATOR_PASSWORD_FILE": str(tmp_path / "password")}
    assert settings_from(environment).operator_password == "correct horse"
    with pytest.raises(SettingsError, match="both given"):
        settings_from(environment | {"CAMPUSLOOP_OPERATOR_PASSWORD": "another"})
    with pytest.raises(SettingsError, match=r"CAMPUSLOOP_OPERATOR_PASSWORD_FILE: .*nowhere"):
        settings_from({"CAMPUSLOOP_OPERATOR_PASSWORD_FILE": str(tmp_path / "nowhere")})


def test_a_file_for_what_is_no_text_is_left_alone(tmp_path: Path) -> None:
    assert settings_from({"CAMPUSLOOP_PORT_FILE": str(tmp_path), "CAMPUSLOOP_NONE_FILE": "x"}).port == 8080
