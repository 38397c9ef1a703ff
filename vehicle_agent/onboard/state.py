"""What a vehicle remembers from one tick to the next: one field a room, nothing else."""

from typing import Any

import msgspec


class OnboardState(msgspec.Struct, frozen=True):
    """Each room's own state, opaque to everybody else; `tick` counts from 0 at boot."""

    tick: int
    can: Any
    localization: Any
    perception: Any
    world: Any
    mission: Any
    planning: Any
    control: Any
    guard: Any
    hmi: Any
