"""Foreign lanelets as strips of road: bounds in one direction, their middle, and what their tags say."""

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from contract.geometry import Array, arc_lengths, pose_at, wrap_angle
from contract.roads.load import MapError
from server.feeds.roads.exchange.lanelet_file import LaneletFile, Relation, Tags, line_of
from server.feeds.roads.exchange.middle_line import middle_of
from server.feeds.roads.lanes.curves import end_poses
from server.feeds.roads.lanes.drafts import ImportLog
from server.feeds.roads.lanes.roads import SHARPEST_TURN_RAD

_DRIVEN = {"road", "highway", "bus_lane", "play_street", "bus_bicycle_lane", "exit"}
_VEHICLES = ("participant:vehicle", "participant:vehicle:bus", "participant:vehicle:car")
_SPEED = re.compile(r"^\s*([0-9.]+)\s*(km/h|kmh|m/s|mps|mph)?\s*$")
_UNITS_MPS = {None: 1 / 3.6, "km/h": 1 / 3.6, "kmh": 1 / 3.6, "m/s": 1.0, "mps": 1.0, "mph": 0.44704}
_DEFAULT_SPEED_MPS = 15 / 3.6
# Ends that are this near, and lead in about the same direction, follow each other.
_JOINT_REACH_M = 0.3
_JOINT_BEND_RAD = 0.5
_BESIDE_M = 0.3
_SQUARE_RAD = 0.5


@dataclass(slots=True)
class Strip:
    """One direction along a lanelet: points (n, 2) are its middle.

    poses  (x, y, yaw) at its start and end
    sides  the middle of its left bound and that of its right one
    """

    name: str
    points: Array
    width_m: float
    speed_limit_mps: float
    is_turn: bool
    poses: tuple[Array, Array]
    sides: tuple[tuple[float, float], tuple[float, float]]


def strips_of(
    file: LaneletFile, places: Mapping[int, tuple[float, float]], log: ImportLog
) -> tuple[list[Strip], list[tuple[str, tuple[float, float]]]]:
    """(strips that a shuttle may drive, (name, middle) of crosswalks). Raises MapError lanelet_broken."""
    strips: list[Strip] = []
    crosswalks: list[tuple[str, tuple[float, float]]] = []
    slow = 0
    for number, relation in file.relations.items():
        if relation.tags.get("type") != "lanelet":
            continue
        left, right = _bounds(file, places, number, relation)
        subtype = relation.tags.get("subtype", "road")
        if subtype == "crosswalk":
            middle = np.vstack((left, right)).mean(axis=0)
            crosswalks.append((f"crossing-{number}", (float(middle[0]), float(middle[1]))))
            continue
        if not _may_be_driven(subtype, relation.tags):
            log.dropped.append(f"lanelet {number}: {subtype}, not for vehicles")
            continue
        speed_mps = _speed(file, relation)
        slow += speed_mps is None
        strips += _both_ways(file, places, number, relation, left, right, speed_mps or _DEFAULT_SPEED_MPS)
    if slow:
        log.repairs.append(f"{slow} lanelets name no speed limit: taken as 15 km/h")
    if not strips:
        raise MapError("no_roads", "the file has no lanelet that a vehicle may drive; export the roads too")
    return strips, crosswalks


def joined_strips(strips: Sequence[Strip]) -> tuple[list[list[int]], list[tuple[Array, Array]]]:
    """(successors of each strip, its poses (x, y, yaw) at start and end): ends that meet share one pose."""
    poses = [strip.poses for strip in strips]
    starts = np.array([pose[0] for pose in poses])
    tree = cKDTree(starts[:, :2])
    successors: list[list[int]] = []
    root = list(range(2 * len(strips)))

    def find(k: int) -> int:
        while root[k] != k:
            k = root[k]
        return k

    for number, (_, end) in enumerate(poses):
        near = sorted(tree.query_ball_point(end[:2], _JOINT_REACH_M))
        after = [k for k in near if abs(wrap_angle(float(starts[k, 2] - end[2]))) <= _JOINT_BEND_RAD]
        successors.append(after)
        for k in after:
            one, other = find(2 * number + 1), find(2 * k)
            root[max(one, other)] = min(one, other)
    meeting: dict[int, list[Array]] = {}
    for k in range(2 * len(strips)):
        meeting.setdefault(find(k), []).append(poses[k // 2][k % 2])
    shared = {joint: _mean_pose(np.array(ends)) for joint, ends in meeting.items()}
    return successors, [(shared[find(2 * k)], shared[find(2 * k + 1)]) for k in range(len(strips))]


def turns_round(poses: tuple[Array, Array]) -> bool:
    """From start to end (x, y, yaw) it turns by more than a turn does."""
    return abs(wrap_angle(float(poses[1][2] - poses[0][2]))) > SHARPEST_TURN_RAD


def _mean_pose(poses: Array) -> Array:
    yaw = math.atan2(float(np.sin(poses[:, 2]).mean()), float(np.cos(poses[:, 2]).mean()))
    return np.array([*np.round(poses[:, :2].mean(axis=0), 4), yaw])


def passing_strips(strips: Sequence[Strip]) -> dict[str, float]:
    """{name: width of both} of strips beside which one of the opposite direction lies: they share a bound."""
    lefts = cKDTree(np.array([strip.sides[0] for strip in strips]))
    found = {}
    for number, strip in enumerate(strips):
        for k in sorted(lefts.query_ball_point(strip.sides[0], _BESIDE_M)):
            if k != number and float(np.dot(_heading(strip), _heading(strips[k]))) < -0.5:
                found[strip.name] = strip.width_m + strips[k].width_m
    return found


def _heading(strip: Strip) -> Array:
    s = arc_lengths(strip.points)
    _, _, yaw = pose_at(strip.points, s, float(s[-1]) / 2.0)
    return np.array([math.cos(yaw), math.sin(yaw)])


def _bounds(
    file: LaneletFile, places: Mapping[int, tuple[float, float]], number: int, relation: Relation
) -> tuple[Array, Array]:
    """(left, right) in the direction in which left is on the left."""
    sides = []
    for role in ("left", "right"):
        ways = relation.of_role(role)
        if not ways:
            raise MapError("lanelet_broken", f"lanelet {number} has no {role} bound; export it again")
        lines = [line_of(file, places, way, f"lanelet {number}") for way in ways]
        sides.append(_chained(lines))
    left, right = sides
    if math.dist(left[0], right[0]) + math.dist(left[-1], right[-1]) > math.dist(
        left[0], right[-1]
    ) + math.dist(left[-1], right[0]):
        right = right[::-1]
    along = (left[-1] + right[-1]) - (left[0] + right[0])
    across = left.mean(axis=0) - right.mean(axis=0)
    if along[0] * across[1] - along[1] * across[0] < 0.0:
        left, right = left[::-1], right[::-1]
    return left, right


def _chained(lines: list[Array]) -> Array:
    """Several ways of one bound end to end, each turned round where that fits better."""
    chain = lines[0]
    for line in lines[1:]:
        if min(math.dist(chain[0], line[0]), math.dist(chain[0], line[-1])) < min(
            math.dist(chain[-1], line[0]), math.dist(chain[-1], line[-1])
        ):
            chain = chain[::-1]
        turned = line[::-1] if math.dist(chain[-1], line[-1]) < math.dist(chain[-1], line[0]) else line
        chain = np.vstack((chain, turned[1:] if math.dist(chain[-1], turned[0]) < 1e-6 else turned))
    return chain


def _may_be_driven(subtype: str, tags: Tags) -> bool:
    said = [key for key in tags if key.startswith("participant:")]
    if said:
        return any(tags.get(key) == "yes" for key in _VEHICLES)
    return subtype in _DRIVEN


def _speed(file: LaneletFile, relation: Relation) -> float | None:
    """The limit of the lanelet, or of a regulatory element of it; None where neither names one."""
    rules = [
        file.relations[ref].tags
        for kind, role, ref in relation.members
        if kind == "relation" and role == "regulatory_element" and ref in file.relations
    ]
    texts = [relation.tags.get("speed_limit", "")]
    texts += [tags.get("sign_type", "") for tags in rules if tags.get("subtype") == "speed_limit"]
    for text in texts:
        match = _SPEED.match(text)
        if match and float(match[1]) > 0.0:
            return float(match[1]) * _UNITS_MPS[match[2]]
    return None


def _both_ways(
    file: LaneletFile,
    places: Mapping[int, tuple[float, float]],
    number: int,
    relation: Relation,
    left: Array,
    right: Array,
    speed_mps: float,
) -> list[Strip]:
    middle, width_m = middle_of(left, right)
    drawn = relation.of_role("centerline")
    if drawn:
        middle = line_of(file, places, drawn[0], f"lanelet {number}")
        if math.dist(middle[0], left[0]) > math.dist(middle[-1], left[0]):
            middle = middle[::-1]
    sides = (_halfway(left), _halfway(right))
    is_turn = "turn_direction" in relation.tags
    poses = _poses(middle, left, right)
    ahead = Strip(str(number), middle, width_m, speed_mps, is_turn, poses, sides)
    if relation.tags.get("one_way", "yes") != "no":
        return [ahead]
    return [
        ahead,
        Strip(
            f"{number}-back",
            middle[::-1],
            width_m,
            speed_mps,
            is_turn,
            _poses(middle[::-1], right[::-1], left[::-1]),
            sides[::-1],
        ),
    ]


def _poses(middle: Array, left: Array, right: Array) -> tuple[Array, Array]:
    """The headings at the ends of the middle; square to the bounds where these say something else."""
    poses = end_poses(middle)
    for pose, across in zip(poses, (left[0] - right[0], left[-1] - right[-1]), strict=True):
        square = math.atan2(-across[0], across[1])
        if abs(wrap_angle(float(pose[2]) - square)) > _SQUARE_RAD:
            pose[2] = square
    return poses


def _halfway(points: Array) -> tuple[float, float]:
    s = arc_lengths(points)
    x_m, y_m, _ = pose_at(points, s, float(s[-1]) / 2.0)
    return x_m, y_m
