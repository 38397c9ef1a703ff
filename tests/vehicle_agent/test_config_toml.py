from pathlib import Path

import msgspec
import pytest

import vehicle_agent
from vehicle_agent.config import Profile, ProfileError, load_profile, profile_toml

PROFILES = Path(vehicle_agent.__file__).parent / "profiles"


def test_a_written_profile_is_read_as_it_was(tmp_path: Path) -> None:
    response = msgspec.structs.replace(Profile().response, steer_bias_rad=-0.0123, brake_gain=0.31)
    profile = msgspec.structs.replace(Profile(), name='a "quoted" name', response=response)
    path = tmp_path / "profile.toml"
    path.write_text(profile_toml(profile), encoding="utf-8")
    assert load_profile(path) == profile


@pytest.mark.parametrize(
    ("lines", "field"),
    [
        ("accel_mps2_max = 0.0", "accel_mps2_max"),
        ("accel_mps2_max = 0.8\naccel_mps2_top = 0.9", "accel_mps2_top"),
        ("accel_mps2_top = 0.0", "accel_mps2_top"),
    ],
)
def test_a_drive_that_does_not_accelerate_or_more_at_speed_than_from_rest_is_refused(
    tmp_path: Path, lines: str, field: str
) -> None:
    path = tmp_path / "profile.toml"
    path.write_text(f"[limits]\n{lines}\n", encoding="utf-8")
    with pytest.raises(ProfileError, match=field):
        load_profile(path)


@pytest.mark.parametrize("shipped", sorted(PROFILES.glob("*.toml")), ids=lambda path: path.stem)
def test_a_shipped_profile_is_written_as_it_was_read(tmp_path: Path, shipped: Path) -> None:
    profile = load_profile(shipped)
    path = tmp_path / "profile.toml"
    path.write_text(profile_toml(profile), encoding="utf-8")
    assert load_profile(path) == profile


@pytest.mark.parametrize(
    "line",
    [
        "brake_gain = 0.0",
        "steer_dead_s = 2.0",
        "brake_lag_s = -0.1",
        "steer_bias_rad = nan",
        "coast_mps2 = 9.0",
    ],
)
def test_a_response_that_no_vehicle_has_is_refused_by_its_name(tmp_path: Path, line: str) -> None:
    path = tmp_path / "profile.toml"
    path.write_text(f"[response]\n{line}\n", encoding="utf-8")
    with pytest.raises(ProfileError, match=line.split()[0]):
        load_profile(path)
