"""Mail between the processes of one vehicle computer: Unix datagram sockets in a folder, one a process.

A datagram arrives whole or not at all, and in order. A sender never waits: mail that the receiver's queue has
no room for waits at the sender, since many kernels queue ten datagrams only. A process that is gone loses its
mail; after a restart it binds the same path again.
"""

import socket
from collections import deque
from collections.abc import Callable
from pathlib import Path

import msgspec

from contract.runlog.arrays import dec_hook, enc_hook
from contract.scan_parcels.parcels import FixRow, PoseRow
from contract.tracing import Span
from contract.wire.localization_maps import LocalizationMapFailure
from contract.wire.maps import MapFailure
from contract.wire.scans import ScanArea
from vehicle_agent.link.bridge import TickUpdate
from vehicle_agent.onboard.cabin_view import CabinView
from vehicle_agent.runtime.recording.recorder import RunLogEntry
from vehicle_agent.runtime.recording.scan_keeper import RequestReport
from vehicle_agent.runtime.video.camera_view import CameraShown, ShowCamera
from vehicle_agent.runtime.video.wanted_spans import VideoMark
from vehicle_agent.signals import CanFrame, InboxBody, LocalizationJob, PlanJob
from vehicle_agent.signals.objects import EgoMotion

DATAGRAM_BYTES_MAX = 200_000
BUFFER_BYTES = 4 * 1024 * 1024
# For each receiver: five seconds of a tick's mail.
WAITING_MAX = 250


class Delivery(msgspec.Struct, frozen=True):
    """To the tick: one inbox item."""

    arrival_ns: int
    source: str
    body: InboxBody


class Deliveries(msgspec.Struct, frozen=True, tag="deliveries"):
    items: tuple[Delivery, ...]


class Commands(msgspec.Struct, frozen=True, tag="commands"):
    """To the gate: one tick's frames.

    rides: those for which these frames are the first ones with a throttle, if rides are traced
    """

    frames: tuple[CanFrame, ...]
    rides: tuple[str, ...] = ()


class TickReport(msgspec.Struct, frozen=True, tag="tick_report"):
    """To the link: data for the server, and run-log entries."""

    update: TickUpdate | None
    entries: tuple[RunLogEntry, ...]


class PlannerJobs(msgspec.Struct, frozen=True, tag="work"):
    """To the planner: one tick's jobs."""

    jobs: tuple[PlanJob, ...]


class LocalizationJobs(msgspec.Struct, frozen=True, tag="localization"):
    """To the localization worker: one tick's jobs."""

    jobs: tuple[LocalizationJob, ...]


class TickMotion(msgspec.Struct, frozen=True, tag="tick_motion"):
    """To the perception worker that tracks road users: the vehicle's motion of one tick."""

    motion: EgoMotion


class TracedSpans(msgspec.Struct, frozen=True, tag="spans"):
    """To the link, which sends them: tick and gate have no time for that."""

    spans: tuple[Span, ...]


class CabinUpdate(msgspec.Struct, frozen=True, tag="cabin"):
    """To the onboard screen."""

    view: CabinView


class MapOffer(msgspec.Struct, frozen=True, tag="map_offer"):
    """To the tick: change over to this map when that is safe; "" withdraws what was offered before."""

    map_version: str


class MapAnswer(msgspec.Struct, frozen=True, tag="map_answer"):
    """To the link and the screen: the tick drives by this map; or it does not, and why."""

    map_version: str
    refusal: MapFailure | None = None
    detail: str = ""


class ScanWork(msgspec.Struct, frozen=True, tag="scan_work"):
    """To the process that keeps scans: all open requests."""

    areas: tuple[ScanArea, ...]


class ScanTrack(msgspec.Struct, frozen=True, tag="scan_track"):
    """To the process that keeps scans: what the tick knew of its place, and the fixes it took."""

    poses: tuple[PoseRow, ...]
    fixes: tuple[FixRow, ...]


class ScanReports(msgspec.Struct, frozen=True, tag="scan_reports"):
    """To the link: how it stands with each open request."""

    reports: tuple[RequestReport, ...]


class LocalizationMapOffer(msgspec.Struct, frozen=True, tag="localization_map_offer"):
    """To the tick: change over to this map when the vehicle stands; "" withdraws what was offered before."""

    map_version: str


class LocalizationMapAnswer(msgspec.Struct, frozen=True, tag="localization_map_answer"):
    """To the link and the localization worker: this map is in force on the vehicle; or not, and why."""

    map_version: str
    refusal: LocalizationMapFailure | None = None
    detail: str = ""


Mail = (
    Deliveries
    | Commands
    | TickReport
    | PlannerJobs
    | LocalizationJobs
    | TickMotion
    | TracedSpans
    | CabinUpdate
    | MapOffer
    | MapAnswer
    | ScanWork
    | ScanTrack
    | ScanReports
    | VideoMark
    | ShowCamera
    | CameraShown
    | LocalizationMapOffer
    | LocalizationMapAnswer
)

_encoder = msgspec.msgpack.Encoder(enc_hook=enc_hook)
_decoder: msgspec.msgpack.Decoder[Mail] = msgspec.msgpack.Decoder(Mail, dec_hook=dec_hook)


class Mailbox:
    """One process's socket.

    lost  count of mail to a process that is gone, or too slow for `WAITING_MAX` of its mail
    """

    def __init__(self, path: Path, on_lost: Callable[[Mail], None] | None = None) -> None:
        """Binds at `path`; replaces the mailbox of a killed process.

        on_lost: called with each lost mail, one receiver's in their order, before `post` or `take` returns
        """
        path.parent.mkdir(parents=True, exist_ok=True)
        path.unlink(missing_ok=True)
        self.path = path
        self.lost = 0
        self._on_lost = on_lost
        self._waiting: dict[str, deque[tuple[bytes, Mail]]] = {}
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, BUFFER_BYTES)
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, BUFFER_BYTES)
        self._socket.setblocking(False)
        self._socket.bind(str(path))

    def fileno(self) -> int:
        return self._socket.fileno()

    @property
    def has_waiting(self) -> bool:
        """Mail waits for room at its receiver; the next `post` or `take` tries again."""
        return bool(self._waiting)

    def waiting_for(self, to: Path) -> int:
        """How much mail waits for room at this receiver."""
        return len(self._waiting.get(str(to), ()))

    def post(self, to: Path, mail: Mail) -> bool:
        """Sends mail, or keeps it until the receiver has room; False if mail is lost, which is counted."""
        receiver = str(to)
        waiting = self._waiting.setdefault(receiver, deque())
        waiting.append((_encoder.encode(mail), mail))
        return self._send_waiting(receiver)

    def take(self) -> list[Mail]:
        """All mail received, in order. Sends what has waited for room."""
        for receiver in tuple(self._waiting):
            self._send_waiting(receiver)
        mail: list[Mail] = []
        while True:
            try:
                data = self._socket.recv(BUFFER_BYTES)
            except BlockingIOError:
                return mail
            mail.append(_decoder.decode(data))

    def _send_waiting(self, receiver: str) -> bool:
        """Sends one receiver's mail, oldest first; False if some is lost."""
        waiting = self._waiting[receiver]
        lost: list[Mail] = []
        while waiting:
            data, mail = waiting[0]
            try:
                self._socket.sendto(data, receiver)
            except BlockingIOError:
                if len(waiting) <= WAITING_MAX:
                    break
                lost.append(mail)
            except (FileNotFoundError, ConnectionRefusedError):
                lost.append(mail)
            waiting.popleft()
        if not waiting:
            del self._waiting[receiver]
        self.lost += len(lost)
        if self._on_lost is not None:
            for mail in lost:
                self._on_lost(mail)
        return not lost

    def close(self) -> None:
        self._socket.close()
        self.path.unlink(missing_ok=True)


class MailedSpans:
    """Spans that go to the vehicle's link by mail."""

    def __init__(self, mailbox: Mailbox, link: Path) -> None:
        self._mailbox, self._link = mailbox, link

    def add(self, span: Span) -> None:
        self._mailbox.post(self._link, TracedSpans((span,)))

    def close(self) -> None:
        """Nothing is left."""
