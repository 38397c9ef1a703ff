"""Which vehicle each stack drives when scenes compare the stacks."""

from pathlib import Path

from vehicle_agent.config import Profile, ProfileError, load_profile

FOLDER = Path(__file__).resolve().parents[2] / "vehicle_agent" / "profiles"
PROFILES = {"snow_lion": "snow-lion.toml", "gem": "campus-shuttle.toml", "nus": "nus-cart.toml"}


def profile_of(stack: str) -> Profile:
    """The stack's own vehicle. ProfileError for a stack that this version lacks."""
    path = FOLDER / PROFILES.get(stack, "")
    if not path.is_file():
        known = ", ".join(name for name, file in PROFILES.items() if (FOLDER / file).is_file())
        raise ProfileError(f"this version has no stack {stack!r}; it has: {known}")
    return load_profile(path)
