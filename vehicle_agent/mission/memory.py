"""What survives a crash of the vehicle computer: written to disk before an order is acknowledged."""

import msgspec

from contract.wire.messages import (
    Order,
    OrderProgress,
    RiderTask,
    SectionGrant,
    Visit,
    VisitProgress,
    VisitState,
)

_KEPT = 64


class StandingAnnouncement(msgspec.Struct, frozen=True):
    """What the onboard screen shows, in English and Chinese, until `until_ns` of the server's clock."""

    text: str
    text_zh: str
    until_ns: int


class MissionMemory(msgspec.Struct, frozen=True):
    """The order and its progress.

    visits    progress of the order's visits, in order
    aboard    parties in the vehicle
    settled   rides that alighted or did not show up; they do not board again
    overdue   rides that stayed aboard at their stop
    behind    visits done or skipped under any order; no order may contain them again
    occupied  granted sections in which the body is
    released  released grants; a late message does not bring them back
    past      earlier orders and their last revision
    heard     ids of commands and taps already executed
    shown     the operators' announcement that the screens show, None without one
    """

    order: Order | None = None
    visits: tuple[VisitProgress, ...] = ()
    aboard: tuple[RiderTask, ...] = ()
    settled: tuple[str, ...] = ()
    overdue: tuple[str, ...] = ()
    behind: tuple[str, ...] = ()
    grants: tuple[SectionGrant, ...] = ()
    occupied: tuple[SectionGrant, ...] = ()
    released: tuple[SectionGrant, ...] = ()
    past: tuple[tuple[str, int], ...] = ()
    heard: tuple[str, ...] = ()
    shown: StandingAnnouncement | None = None

    def open_visits(self) -> tuple[Visit, ...]:
        """Visits not yet done or skipped, the one under way first."""
        if self.order is None:
            return ()
        states = {progress.visit_id: progress.state for progress in self.visits}
        return tuple(v for v in self.order.visits if states[v.visit_id] in ("pending", "under_way"))

    def visit_state(self, visit_id: str) -> VisitState | None:
        """The state of a visit; None if the order does not have it."""
        return next((p.state for p in self.visits if p.visit_id == visit_id), None)

    @property
    def under_way(self) -> str:
        """The visit that is under way, or ""."""
        return next((p.visit_id for p in self.visits if p.state == "under_way"), "")

    @property
    def seats_taken(self) -> int:
        """Number of people in the parties aboard."""
        return sum(rider.party for rider in self.aboard)

    def with_visit(self, visit_id: str, state: VisitState) -> "MissionMemory":
        """The memory after a visit changed; a visit that ends is kept in `behind`."""
        visits = tuple(VisitProgress(visit_id, state) if p.visit_id == visit_id else p for p in self.visits)
        behind = remembered(self.behind, visit_id) if state in ("done", "skipped") else self.behind
        return msgspec.structs.replace(self, visits=visits, behind=behind)


def remembered(known: tuple[str, ...], new: str) -> tuple[str, ...]:
    """The latest ids with a new one, the new one last."""
    return (*known, new)[-_KEPT:]


def order_progress(memory: MissionMemory) -> OrderProgress | None:
    """The order's progress for the next hello to the server; None without an order."""
    if memory.order is None:
        return None
    sections = tuple(grant.section_id for grant in memory.grants)
    return OrderProgress(memory.order.order_id, memory.order.revision, memory.visits, sections)
