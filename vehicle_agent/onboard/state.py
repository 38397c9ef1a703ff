"""The onboard state from one tick to the next: one field a room."""

from typing import Any, TypeAlias

import msgspec

# A room's own struct, opaque to all others; the stack decides which struct it is. Each room's protocol in
# `car.py` binds its implementation to one type of state.
RoomState: TypeAlias = Any


class OnboardState(msgspec.Struct, frozen=True):
    """Each room's own state; `tick` counts from 0 at boot."""

    tick: int
    can: RoomState
    localization: RoomState
    perception: RoomState
    world: RoomState
    mission: RoomState
    planning: RoomState
    control: RoomState
    guard: RoomState
    hmi: RoomState
