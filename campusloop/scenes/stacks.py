"""The vehicle of each stack, for scenes that compare the stacks."""

import msgspec

from campusloop.shipped import PROFILES
from vehicle_agent.config import Profile, ProfileError, load_profile

PROFILE_OF_STACK = {"snow_lion": "snow-lion.toml", "gem": "campus-shuttle.toml", "nus": "nus-cart.toml"}


def profile_of(stack: str) -> Profile:
    """The stack's own vehicle. ProfileError for a stack that this version lacks."""
    path = PROFILES / PROFILE_OF_STACK.get(stack, "")
    if not path.is_file():
        known = ", ".join(name for name, file in PROFILE_OF_STACK.items() if (PROFILES / file).is_file())
        raise ProfileError(f"this version has no stack {stack!r}; it has: {known}")
    return load_profile(path)


def perceiving(profile: Profile, own: bool) -> Profile:
    """The profile with its own perception of road users, or with a tracker of the truth with noise."""
    return msgspec.structs.replace(profile, perception="own" if own else "tracker")
