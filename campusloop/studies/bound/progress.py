"""What a proof may spend, and where it stands."""

from dataclasses import dataclass

# Published costs have two decimals.
CLOSED_WITHIN = 0.005


@dataclass(frozen=True, slots=True)
class Limits:
    """Budgets, all of them counts.

    events_max       of the event graph
    labels_max       stored by one pricing; enumeration_labels_max by one enumeration, pool_max routes out
                     of it
    columns_a_round  taken from one pricing; columns_max kept in the relaxation
    cuts_a_round, cuts_max   subset-row cuts while routes are still priced by labels
    search_routes, search_nodes   of the integer search for a first solution
    """

    events_max: int = 300_000
    labels_max: int = 2_000_000
    enumeration_labels_max: int = 8_000_000
    pool_max: int = 1_500_000
    columns_a_round: int = 100
    columns_max: int = 4000
    cuts_a_round: int = 30
    cuts_max: int = 250
    search_routes: int = 1500
    search_nodes: int = 20


@dataclass(frozen=True, slots=True)
class Progress:
    """Where the proof stands: bound is proven at every moment.

    upper     cost of the best solution that the proof has found, inf for none
    solution  its routes as node indices of the instance
    limit     which of its limits the proof has met last, "" for none
    """

    stage: str
    bound: float
    upper: float
    columns: int
    rounds: int
    cuts: int
    nodes: int
    solution: tuple[tuple[int, ...], ...]
    limit: str

    @property
    def closed(self) -> bool:
        """Is its own solution optimal, to the second decimal?"""
        return self.upper - self.bound < CLOSED_WITHIN
