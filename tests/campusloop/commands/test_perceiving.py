"""Which vehicle sees for itself, and what an operator is told that it lacks."""

from pathlib import Path

import msgspec
import pytest
from rich.console import Console

from campusloop.commands.perceiving import Perception, perceiving_profile, tell_lacks
from campusloop.scenes.stacks import profile_of
from vehicle_agent.config import PlanarScanner, ProfileError, load_profile


def test_without_a_profile_it_is_the_shipped_campus_shuttle_with_all_its_sensors(tmp_path: Path) -> None:
    written = perceiving_profile(Perception.OWN, None, tmp_path, has_scene=True)
    assert written is not None
    assert load_profile(written) == msgspec.structs.replace(profile_of("gem"), perception="own")
    assert perceiving_profile(None, None, tmp_path, has_scene=True) is None


def test_what_it_lacks_is_told_with_the_name_of_the_table() -> None:
    blind = msgspec.structs.replace(profile_of("gem"), perception="own", people_scanner=PlanarScanner())
    console = Console(record=True, width=200)
    tell_lacks(console, blind)
    assert "campus-shuttle has no [people_scanner]" in console.export_text()


def test_own_perception_without_a_scene_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ProfileError, match="--scene"):
        perceiving_profile(Perception.OWN, None, tmp_path, has_scene=False)
