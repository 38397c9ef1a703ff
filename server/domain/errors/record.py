"""Refusals of recorded runs and incidents."""

from server.domain.errors.base import DomainError


class RunUnknown(DomainError):
    """No run of this vehicle and boot is stored."""

    code = "run_unknown"


class RunMapUnreadable(DomainError):
    """The run's recording holds no road map that can be drawn."""

    code = "run_map_unreadable"


class SegmentUnknown(DomainError):
    """No segment has this hash."""

    code = "segment_unknown"


class SegmentConflict(DomainError):
    """The same segment number of a run came with other content."""

    code = "segment_conflict"


class AuditEntryUnknown(DomainError):
    """The audit log has no entry of this number."""

    code = "audit_entry_unknown"


class IncidentUnknown(DomainError):
    """No incident has this id."""

    code = "incident_unknown"


class IncidentClosed(DomainError):
    """The incident is closed already."""

    code = "incident_closed"
