"""The answer to an operator who names the vehicle's place: localization tries it, the mission tells."""

import math

import msgspec

from contract.geometry import Pose2
from contract.wire.messages import Command, CommandDone
from vehicle_agent.signals import Ego, takes_hints

# Scans answer within a second; a search in the worker takes half of one for each scan.
_TRIED_NS = 2_000_000_000
_GIVEN_UP_NS = 20_000_000_000


class Placing(msgspec.Struct, frozen=True):
    """A named place that is being tried since `since_ns`."""

    command_id: str
    pose_map: Pose2
    since_ns: int


def why_not_placed(command: Command, ego: Ego) -> str:
    """Why the vehicle does not try the place; "" if it does."""
    if command.pose_map is None:
        return "the command names no place"
    if ego.phase is None:
        return "the vehicle compares no scans with a map: its position is by GNSS alone"
    if not takes_hints(ego.speed_mps):
        return "the vehicle moves: hold it first, then name its place"
    return ""


def placing_result(placing: Placing, ego: Ego, now_ns: int) -> CommandDone | None:
    """What came of it; None while it is not known."""
    tried_ns = now_ns - placing.since_ns
    if tried_ns < _TRIED_NS:
        return None
    if ego.valid and ego.phase in ("tracking", "recovered"):
        named, found = placing.pose_map, ego.pose_map
        off_m = math.hypot(found.x_m - named.x_m, found.y_m - named.y_m)
        return CommandDone(placing.command_id, True, f"scans agree, {off_m:.1f} m from the named place")
    if tried_ns < _GIVEN_UP_NS:
        return None
    if ego.phase == "gnss_only":
        detail = "the point map has nothing there, or no scans come: the position is by GNSS alone"
    else:
        detail = "scans do not agree with the named place: name a better one, or drive it onto a mapped road"
    return CommandDone(placing.command_id, False, detail)
