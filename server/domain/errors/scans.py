"""Refusals of requests for scans and of proposed point maps."""

from server.domain.errors.base import DomainError


class ScanAreaInvalid(DomainError):
    """The area crosses itself, or no road of the campus leads through it."""

    code = "scan_area_invalid"


class ScanAreaTaken(DomainError):
    """An open request for scans covers a part of this area; end it first."""

    code = "scan_area_taken"


class ScanRequestUnknown(DomainError):
    """No request for scans has this id."""

    code = "scan_request_unknown"


class ScanRequestOver(DomainError):
    """The request for scans has ended already."""

    code = "scan_request_over"


class ParcelRefused(DomainError):
    """The parcel of scans is of another campus, map frame or vehicle, or was not asked for."""

    code = "parcel_refused"


class NoScansYet(DomainError):
    """No vehicle has sent scans for this request yet."""

    code = "no_scans_yet"


class ProposalUnderWay(DomainError):
    """A map of these scans is being made already."""

    code = "proposal_under_way"


class ProposalUnknown(DomainError):
    """No proposed map has this id."""

    code = "proposal_unknown"


class ProposalNotReady(DomainError):
    """The proposed map is not ready, has been decided on, or is not being made any more."""

    code = "proposal_not_ready"


class ProposalOutdated(DomainError):
    """Another point map is in force than the one that the proposal was compared with; make it again."""

    code = "proposal_outdated"


class ScanMapsUnavailable(DomainError):
    """No process of this installation makes point maps of scans."""

    code = "scan_maps_unavailable"
