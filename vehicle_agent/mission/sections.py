"""Movement authority: staying within the granted sections, and releasing those left behind."""

from collections import Counter

import msgspec

from contract.wire.messages import SectionGrant, SectionReleased
from vehicle_agent.mission.memory import MissionMemory

Span = tuple[str, float, float]


class VehicleExtent(msgspec.Struct, frozen=True):
    """The vehicle's extent along the line, from the rear axle."""

    front_m: float
    back_m: float


class OccupiedSection(msgspec.Struct, frozen=True):
    """A granted section that the body is in; the rear bumper leaves it at odometer reading exit_m."""

    grant: SectionGrant
    exit_m: float


class MovementAuthority(msgspec.Struct, frozen=True):
    """How far the grants reach: hold_s_m for the rear axle, and the first section that lacks one, if any."""

    hold_s_m: float
    waiting_for: str


def movement_authority(
    spans: tuple[Span, ...],
    grants: tuple[SectionGrant, ...],
    s_m: float,
    body: VehicleExtent,
    margin_m: float,
) -> MovementAuthority:
    """How far the grants allow the vehicle to drive.

    spans   (section_id, from, to) along the line, in order; a section that occurs twice needs two grants
    The front bumper stays margin_m before the first section without a grant.
    """
    left = Counter(grant.section_id for grant in grants)
    for section_id, from_m, to_m in spans:
        if to_m <= s_m - body.back_m:
            continue
        if left[section_id] > 0:
            left[section_id] -= 1
        elif to_m > s_m:
            return MovementAuthority(from_m - body.front_m - margin_m, section_id)
    return MovementAuthority(float("inf"), "")


def find_occupied_sections(
    known: tuple[OccupiedSection, ...],
    spans: tuple[Span, ...],
    grants: tuple[SectionGrant, ...],
    s_m: float,
    odometer_m: float,
    body: VehicleExtent,
) -> tuple[OccupiedSection, ...]:
    """The granted sections that the body is in or has left, each with the odometer reading at its exit."""
    fences: dict[str, SectionGrant] = {}
    for grant in grants:
        fences.setdefault(grant.section_id, grant)
    found = {section.grant.section_id: section for section in known}
    for section_id, from_m, to_m in spans:
        if from_m >= s_m + body.front_m:
            break
        if to_m > s_m - body.back_m and section_id in fences:
            found[section_id] = OccupiedSection(fences[section_id], odometer_m + to_m - s_m + body.back_m)
    for grant in _granted_behind(spans, grants, s_m - body.back_m):
        if grant.section_id not in found or found[grant.section_id].grant != grant:
            found[grant.section_id] = OccupiedSection(grant, odometer_m)
    return tuple(found.values())


def _granted_behind(
    spans: tuple[Span, ...], grants: tuple[SectionGrant, ...], tail_m: float
) -> tuple[SectionGrant, ...]:
    """The grants of sections behind the tail: those before the one that it is in, in driving order.

    A vehicle is placed with the ground under a body that is a little larger than its own, and with the end
    of the lane before the one on which its line begins.
    """
    under_tail = next((section_id for section_id, _, to_m in spans if to_m > tail_m), "")
    if tail_m < 0.0:
        return ()
    return grants[: next((n for n, grant in enumerate(grants) if grant.section_id == under_tail), 0)]


def release_sections(
    memory: MissionMemory, standing: tuple[OccupiedSection, ...], odometer_m: float, slack_m: float
) -> tuple[MissionMemory, tuple[OccupiedSection, ...], tuple[SectionReleased, ...]]:
    """Releases every section that the rear bumper has left by slack_m, with its grant's fence."""
    left = tuple(section.grant for section in standing if odometer_m > section.exit_m + slack_m)
    remaining = tuple(section for section in standing if section.grant not in left)
    occupied = tuple(section.grant for section in remaining)
    if left or occupied != memory.occupied:
        memory = msgspec.structs.replace(
            memory,
            occupied=occupied,
            grants=_without(memory.grants, left),
            released=(*memory.released, *left)[-64:],
        )
    return memory, remaining, tuple(SectionReleased(grant.section_id, grant.fence) for grant in left)


def _without(grants: tuple[SectionGrant, ...], left: tuple[SectionGrant, ...]) -> tuple[SectionGrant, ...]:
    """The grants without the first grant of each section left."""
    remaining = list(grants)
    for grant in left:
        match = next((kept for kept in remaining if kept.section_id == grant.section_id), None)
        if match is not None:
            remaining.remove(match)
    return tuple(remaining)
