"""Refusals of plans, orders and reserved roads, and of a dispatcher that another one has replaced."""

from server.domain.errors.base import DomainError


class PlanChanged(DomainError):
    """The plan was changed in the meantime: read again, decide again."""

    code = "plan_changed"


class VisitUnknown(DomainError):
    """The plan has no such visit."""

    code = "visit_unknown"


class OrderUnknown(DomainError):
    """The vehicle names an order that the server never issued."""

    code = "order_unknown"


class NoRestingPlaceFree(DomainError):
    """Every resting place that the vehicle can reach is reserved for another one."""

    code = "no_resting_place_free"


class SectionsTaken(DomainError):
    """The vehicle stands on sections that another one holds."""

    code = "sections_taken"


class LeaseLost(DomainError):
    """Another replica has taken over the task."""

    code = "lease_lost"
