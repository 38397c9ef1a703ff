"""Refusals of recorded runs, incidents and webhooks."""

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


class ForkImpossible(DomainError):
    """The past cannot be forked at this moment: there is nothing to dispatch, or too much."""

    code = "fork_impossible"


class ForkStopped(DomainError):
    """The fork was stopped before it was computed."""

    code = "fork_stopped"


class ForkUnknown(DomainError):
    """This server computes no fork of this name, or no longer."""

    code = "fork_unknown"


class ForksBusy(DomainError):
    """This server computes as many forks as it may; try again when they are done."""

    code = "forks_busy"


class RecordingUnknown(DomainError):
    """No recording has this id."""

    code = "recording_unknown"


class RecordingUnderWay(DomainError):
    """The vehicle has a recording that has not been stopped; stop it first."""

    code = "recording_under_way"


class RecordingOver(DomainError):
    """The recording has been stopped already, or the vehicle refused it."""

    code = "recording_over"


class IncidentUnknown(DomainError):
    """No incident has this id."""

    code = "incident_unknown"


class IncidentClosed(DomainError):
    """The incident is closed already."""

    code = "incident_closed"


class WebhookUnknown(DomainError):
    """No webhook that this caller may see has this id."""

    code = "webhook_unknown"


class WebhookInvalid(DomainError):
    """The address or the types of events cannot be used for a webhook."""

    code = "webhook_invalid"


class WebhookDisabled(DomainError):
    """The webhook is disabled; enable it first."""

    code = "webhook_disabled"


class TooManyWebhooks(DomainError):
    """The campus has as many webhooks as it may have; delete one first."""

    code = "too_many_webhooks"
