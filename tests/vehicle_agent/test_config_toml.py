from pathlib import Path

import msgspec

from vehicle_agent.config import Profile, load_profile, profile_toml


def test_a_written_profile_is_read_as_it_was(tmp_path: Path) -> None:
    response = msgspec.structs.replace(Profile().response, steer_bias_rad=-0.0123, brake_gain=0.31)
    profile = msgspec.structs.replace(Profile(), name='a "quoted" name', response=response)
    path = tmp_path / "profile.toml"
    path.write_text(profile_toml(profile), encoding="utf-8")
    assert load_profile(path) == profile
