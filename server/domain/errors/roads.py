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


class DraftUnknown(DomainError):
    """No draft of a map has this id."""

    code = "draft_unknown"


class DraftChanged(DomainError):
    """Someone else has changed the draft since; nothing of it was overwritten."""

    code = "draft_changed"


class DraftUnsound(DomainError):
    """The draft has problems, so it cannot be published."""

    code = "draft_unsound"


class TooManyDrafts(DomainError):
    """There are as many drafts as the server keeps; discard one."""

    code = "too_many_drafts"


class MapElsewhere(DomainError):
    """The file lies far from the map in force."""

    code = "map_elsewhere"


class NoSuchFix(DomainError):
    """This problem cannot be mended automatically, or is there no longer."""

    code = "no_such_fix"


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


class LocalizationMapUnknown(DomainError):
    """No localization map of this version is stored."""

    code = "localization_map_unknown"


class LocalizationMapInvalid(DomainError):
    """The bytes are no manifest of a localization map of this campus."""

    code = "localization_map_invalid"


class LocalizationMapElsewhere(DomainError):
    """The localization map lies in another frame than the road map in force."""

    code = "localization_map_elsewhere"


class LocalizationMapIncomplete(DomainError):
    """Tiles of the localization map are missing; send them first."""

    code = "localization_map_incomplete"


class LocalizationMapInForce(DomainError):
    """The localization map is in force; put another one in force first."""

    code = "localization_map_in_force"


class TooManyLocalizationMaps(DomainError):
    """There are as many localization maps as the server keeps; remove one."""

    code = "too_many_localization_maps"


class LocalizationTileUnknown(DomainError):
    """The localization map names no such tile, or its bytes have not come yet."""

    code = "localization_tile_unknown"


class LocalizationTileInvalid(DomainError):
    """The bytes are not the tile that the manifest names."""

    code = "localization_tile_invalid"
