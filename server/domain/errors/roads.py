"""Refusals of the campus, its map and its road closures."""

from server.domain.errors.base import DomainError


class CampusUnknown(DomainError):
    """The campus has no active map."""

    code = "campus_unknown"


class MapUnknown(DomainError):
    """No map of this version is stored."""

    code = "map_unknown"


class MapInvalid(DomainError):
    """The bytes are no usable road map."""

    code = "map_invalid"


class MapInUse(DomainError):
    """Shuttles are on the road with the active map."""

    code = "map_in_use"


class AreaUnknown(DomainError):
    """The active map has no such observation area."""

    code = "area_unknown"


class StopUnknown(DomainError):
    """The active map has no such stop."""

    code = "stop_unknown"


class StopUnreachable(DomainError):
    """No road leads from the one stop to the other."""

    code = "stop_unreachable"


class LaneUnknown(DomainError):
    """The active map has no such lane."""

    code = "lane_unknown"


class SectionUnknown(DomainError):
    """The active map has no such section."""

    code = "section_unknown"


class ClosureInvalid(DomainError):
    """A road closure closes nothing, or ends before it begins."""

    code = "closure_invalid"


class ClosureUnknown(DomainError):
    """No road closure has this id."""

    code = "closure_unknown"


class ClosureOver(DomainError):
    """The road closure has ended or was lifted already."""

    code = "closure_over"
