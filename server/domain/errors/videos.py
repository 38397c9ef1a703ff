"""Refusals of video."""

from server.domain.errors.base import DomainError


class VideoUnknown(DomainError):
    """No video segment has this hash, or its bytes are no longer kept."""

    code = "video_unknown"


class VideoSpanInvalid(DomainError):
    """The span ends before it begins, or is longer than six hours."""

    code = "video_span_invalid"
