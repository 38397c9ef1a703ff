"""What finds road users for simulated shuttles: their own scans, or a tracker of the truth with noise."""

from enum import StrEnum
from pathlib import Path

import msgspec
from rich.console import Console
from rich.markup import escape

from campusloop.scenes.stacks import profile_of
from vehicle_agent.config import Profile, ProfileError, load_profile, profile_toml
from vehicle_agent.stacks.choice import perception_lacks


class Perception(StrEnum):
    """What an operator may choose."""

    TRACKER = "tracker"
    OWN = "own"


def perceiving(perception: Perception | None, profile: Profile, *, has_scene: bool) -> Profile:
    """The profile with this perception; None: its own word.

    Raises ProfileError for own perception where there is no scene for it to look at.
    """
    chosen = profile if perception is None else msgspec.structs.replace(profile, perception=perception.value)
    if chosen.perception == "own" and not has_scene:
        raise ProfileError(
            "--perception own needs --scene: without it lidars see walls, posts and boxes instead of people"
        )
    return chosen


def perceiving_profile(
    perception: Perception | None, path: Path | None, folder: Path, *, has_scene: bool
) -> Path | None:
    """The file of a profile with this perception: the given one, or one that is written into the folder.

    Without a path it is the campus shuttle. Raises ProfileError, OSError.
    """
    profile = profile_of("gem") if path is None else load_profile(path)
    chosen = perceiving(perception, profile, has_scene=has_scene)
    if chosen == profile:
        return path
    folder.mkdir(parents=True, exist_ok=True)
    written = folder / "perceiving.toml"
    written.write_text(profile_toml(chosen))
    return written


def tell_lacks(console: Console, profile: Profile) -> None:
    """Tell what own perception does without here."""
    lacks = perception_lacks(profile)
    if lacks:
        console.print(f"[yellow]{escape(lacks)}[/yellow]", soft_wrap=True, highlight=False)
