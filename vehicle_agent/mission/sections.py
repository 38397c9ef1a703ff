"""Staying inside the granted sections, and giving back those left behind."""

from collections import Counter

import msgspec

from contract.wire.messages import SectionGrant, SectionReleased
from vehicle_agent.mission.memory import MissionMemory

Span = tuple[str, float, float]


class VehicleExtent(msgspec.Struct, frozen=True):
    """The outline along the line, from the rear axle."""

    front_m: float = 3.5
    back_m: float = 0.85


class OccupiedSection(msgspec.Struct, frozen=True):
    """A granted section with the body in it; it is left when the odometer has passed exit_m."""

    grant: SectionGrant
    exit_m: float


class MovementAuthority(msgspec.Struct, frozen=True):
    """How far the grants reach: hold_s_m for the rear axle, and the first section that lacks one, if any."""

    hold_s_m: float
    waiting_for: str


def leave_to_drive(
    spans: tuple[Span, ...],
    grants: tuple[SectionGrant, ...],
    s_m: float,
    body: VehicleExtent,
    margin_m: float,
) -> MovementAuthority:
    """Where to wait for the next grant.

    spans   (section_id, from, to) along the line, in order; one that comes twice needs a grant each time
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


def footings(
    known: tuple[OccupiedSection, ...],
    spans: tuple[Span, ...],
    grants: tuple[SectionGrant, ...],
    s_m: float,
    odometer_m: float,
    body: VehicleExtent,
) -> tuple[OccupiedSection, ...]:
    """The granted sections that the body is in, each with the odometer reading at which it is left."""
    fences: dict[str, SectionGrant] = {}
    for grant in grants:
        fences.setdefault(grant.section_id, grant)
    found = {footing.grant.section_id: footing for footing in known}
    for section_id, from_m, to_m in spans:
        if from_m >= s_m + body.front_m:
            break
        if to_m > s_m - body.back_m and section_id in fences:
            found[section_id] = OccupiedSection(fences[section_id], odometer_m + to_m - s_m + body.back_m)
    return tuple(found.values())


def released(
    memory: MissionMemory, standing: tuple[OccupiedSection, ...], odometer_m: float, slack_m: float
) -> tuple[MissionMemory, tuple[OccupiedSection, ...], tuple[SectionReleased, ...]]:
    """Give back every section that the rear bumper has left by slack_m; fences are echoed."""
    left = tuple(footing.grant for footing in standing if odometer_m > footing.exit_m + slack_m)
    staying = tuple(footing for footing in standing if footing.grant not in left)
    occupied = tuple(footing.grant for footing in staying)
    if left or occupied != memory.occupied:
        memory = msgspec.structs.replace(
            memory,
            occupied=occupied,
            grants=_without(memory.grants, left),
            released=(*memory.released, *left)[-64:],
        )
    return memory, staying, tuple(SectionReleased(grant.section_id, grant.fence) for grant in left)


def _without(grants: tuple[SectionGrant, ...], gone: tuple[SectionGrant, ...]) -> tuple[SectionGrant, ...]:
    """Of each section left, its first grant."""
    remaining = list(grants)
    for grant in gone:
        match = next((kept for kept in remaining if kept.section_id == grant.section_id), None)
        if match is not None:
            remaining.remove(match)
    return tuple(remaining)
