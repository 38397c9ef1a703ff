"""Which role of an operator, and which scope of a developer token, each kind of endpoint needs."""

from dataclasses import dataclass

from server.domain.record.identity import Role, Scope


@dataclass(frozen=True, slots=True)
class Permission:
    """roles: any of them suffices

    scope          of developer tokens; None: operators only
    second_factor  of an operator who has one: it must have been checked lately. A token's scope is enough
    """

    roles: tuple[Role, ...]
    scope: Scope | None = None
    second_factor: bool = False


LOOK = Permission(("viewer",), "read")
# Rides, roads, messages; with tokens and without.
DISPATCH = Permission(("dispatcher",), "drive")
# Marks and recordings of what a vehicle records always, and what it sees now.
RECORD = Permission(("dispatcher", "safety"), "drive")
# Faces and plates may be in it; who looked at what is in the audit log.
WATCH_VIDEO = Permission(("dispatcher", "safety"))
PREVIEW = Permission(("dispatcher", "safety"), "drive")
RUN_SERVICE = Permission(("dispatcher",))
# What operators write about people is theirs alone.
READ_NOTES = Permission(("viewer",))
HANDLE_INCIDENTS = Permission(("dispatcher", "safety"))
# Stopping never asks for a second factor; setting in motion does.
STOP = Permission(("safety",), "drive")
MOVE = Permission(("safety",), "drive", second_factor=True)
EVACUATE = Permission(("safety",))
PLACE = Permission(("safety",), second_factor=True)
REGISTER_WEBHOOKS = Permission(("admin",), "drive")
DRAW_MAPS = Permission(("dispatcher", "safety"))
# Stored beside the one in force: a survey's computer may send it, an operator puts it in force.
STORE_LOCALIZATION_MAPS = Permission(("dispatcher", "safety"), "drive")
# Where all shuttles drive, or what they localize by, from then on.
PUBLISH_MAPS = Permission(("safety",), second_factor=True)
ADMINISTER = Permission(("admin",))
GIVE_ACCESS = Permission(("admin",), second_factor=True)
