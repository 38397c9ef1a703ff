"""What one session has sent: changes are sent at once, unanswered messages again after a while."""

from collections.abc import Sequence

from contract.wire.messages import (
    Grants,
    LocalizationMapPublished,
    MapPublished,
    Order,
    ScanArea,
    ScansRequested,
    SectionGrant,
    ServerMessage,
)
from server.usecases.orders.outbox import Outbox

REPEAT_AFTER_NS = 3_000_000_000
Announcement = MapPublished | LocalizationMapPublished


class SentMessages:
    """Chooses from an outbox what to send now. Repeats are harmless to the vehicle."""

    __slots__ = ("_grants", "_scans", "_sent_ns", "announced", "announced_localization", "unanswered")

    def __init__(self) -> None:
        """The versions that the vehicle was told of last, "" for none."""
        self.announced = ""
        self.announced_localization = ""
        self._sent_ns: dict[str, int] = {}
        self._grants: tuple[str, tuple[SectionGrant, ...]] = ("", ())
        self._scans: tuple[ScanArea, ...] = ()
        self.unanswered = False

    def choose(
        self,
        outbox: Outbox,
        now_ns: int,
        published: Sequence[Announcement] = (),
        scans: ScansRequested | None = None,
    ) -> list[ServerMessage]:
        """Orders before grants. Afterwards `unanswered` says whether something waits for an answer.

        published: the maps in force, for a vehicle that has others
        scans: all open requests, for a vehicle that can keep scans; a session begins without any
        """
        messages: list[ServerMessage] = []
        still: dict[str, int] = {}
        for key, message in _keyed(outbox, published):
            sent_ns = self._sent_ns.get(key)
            if sent_ns is None or now_ns - sent_ns >= REPEAT_AFTER_NS:
                messages.append(message)
                sent_ns = now_ns
                self._remember_grants(message)
            still[key] = sent_ns
        if outbox.grants is not None and self._have_changed(outbox.grants):
            messages.append(outbox.grants)
            self._remember_grants(outbox.grants)
        if scans is not None and scans.areas != self._scans:
            messages.append(scans)
            self._scans = scans.areas
        for told in published:
            if isinstance(told, MapPublished):
                self.announced = told.map_version
            else:
                self.announced_localization = told.map_version
        self._sent_ns, self.unanswered = still, bool(still)
        return messages

    def _have_changed(self, grants: Grants) -> bool:
        return self._grants != (grants.order_id, grants.sections)

    def _remember_grants(self, message: ServerMessage) -> None:
        if isinstance(message, Order | Grants):
            self._grants = (message.order_id, message.sections)


def _keyed(outbox: Outbox, published: Sequence[Announcement]) -> list[tuple[str, ServerMessage]]:
    keyed: list[tuple[str, ServerMessage]] = []
    keyed += [(f"map {told.map_version}", told) for told in published]
    if outbox.order is not None:
        keyed.append((f"order {outbox.order.order_id} {outbox.order.revision}", outbox.order))
    keyed += [(f"command {command.command_id}", command) for command in outbox.commands]
    keyed += [(f"tap {tap.tap_id}", tap) for tap in outbox.taps]
    return keyed
