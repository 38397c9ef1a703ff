"""The link as a process, for one vehicle or for all simulated ones: bridges, run logs, uploads, sockets.

The tick never waits for it: mail arrives in the vehicle's `link` mailbox, messages go to `tick`.
"""

import asyncio
import signal
import ssl
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import httpx
import msgspec
import structlog

from contract.runlog.records import NO_LOCALIZATION_MAP
from contract.tracing import Spans
from contract.wire.messages import (
    CameraPicture,
    Command,
    OrderProgress,
    ScanArea,
    ScansReported,
    VehicleEvent,
)
from vehicle_agent.link.bridge import LinkBridge, TickUpdate
from vehicle_agent.link.client import LinkClient
from vehicle_agent.link.keys import signature_text
from vehicle_agent.link.localization_download import LocalizationMapNotTaken
from vehicle_agent.link.map_download import MapNotTaken
from vehicle_agent.link.scan_uploads import ScanUploads
from vehicle_agent.link.session import Identity
from vehicle_agent.link.upload import SegmentUploader
from vehicle_agent.link.video_uploads import VideoUploads
from vehicle_agent.runtime.order_tracing import LinkTracing
from vehicle_agent.runtime.processes.agent_files import AgentFolder
from vehicle_agent.runtime.processes.clock import Clock
from vehicle_agent.runtime.processes.link.camera_requests import CameraRequests
from vehicle_agent.runtime.processes.link.video_marks import VideoMarks
from vehicle_agent.runtime.processes.mailbox import (
    Deliveries,
    Delivery,
    LocalizationMapAnswer,
    LocalizationMapOffer,
    Mailbox,
    MapAnswer,
    MapOffer,
    ScanReports,
    ScanWork,
    TickReport,
    TracedSpans,
)
from vehicle_agent.runtime.processes.maps.localization_changer import LocalizationChanger
from vehicle_agent.runtime.processes.maps.map_changer import MapChanger
from vehicle_agent.runtime.processes.sensing.scan_track import track_of
from vehicle_agent.runtime.recording.recorder import SegmentBegin
from vehicle_agent.runtime.recording.runlog_files import RunLogFiles, finished_segment
from vehicle_agent.runtime.recording.scan_keeper import RequestReport
from vehicle_agent.runtime.video.camera_view import CameraShown
from vehicle_agent.signals import LinkMessage

log = structlog.get_logger()

# What the tick sends meanwhile waits, 40 s of it.
WRITE_AGAIN_S = 1.0


@dataclass(frozen=True, slots=True)
class LinkedVehicle:
    """The link's parameters for one vehicle.

    mail      the folder of its mailboxes
    progress  of its order, from the memory on disk
    spans     of the process; None: rides are not traced
    """

    folder: Path
    mail: Path
    identity: Identity
    profile: bytes
    road_map: bytes
    progress: OrderProgress | None
    clock: Clock
    spans: Spans | None = None


class VehicleLink:
    """One vehicle's part of the link process."""

    def __init__(self, vehicle: LinkedVehicle) -> None:
        files = AgentFolder(vehicle.folder)
        config = files.vehicle()
        key = files.key()
        self._clock = vehicle.clock
        self._identity = vehicle.identity
        self._tls = _tls_context(config.server_url, config.server_certificate)
        self._bridge = LinkBridge(
            files.outbox, vehicle.identity, lambda text: signature_text(key, text), vehicle.progress
        )
        self._runs = files.runs
        self._log_files = RunLogFiles(files.runs, vehicle.profile, vehicle.road_map, files.map_bytes)
        self._mailbox = Mailbox(vehicle.mail / "link")
        self._tick = vehicle.mail / "tick"
        self._spans = vehicle.spans
        vehicle_id = vehicle.identity.vehicle_id
        self._tracing = None if vehicle.spans is None else LinkTracing(vehicle.spans, vehicle_id)
        self._utc_offset_ns = vehicle.clock.utc_offset_ns()
        self._tick_boot_id = ""
        self._tick_is_up = asyncio.Event()
        self._reports: asyncio.Queue[TickReport] = asyncio.Queue(maxsize=2000)
        self._http = httpx.AsyncClient(
            base_url=config.server_url, verify=self._tls if self._tls is not None else True
        )
        self._uploader = SegmentUploader(
            vehicle.identity.vehicle_id, self._http, lambda text: signature_text(key, text)
        )
        self._maps = MapChanger(
            vehicle.identity.vehicle_id,
            files,
            self._http,
            lambda text: signature_text(key, text),
            self._report_event,
            self._offer_map,
        )
        self._keeper = vehicle.mail / "scans"
        self._scans = ScanUploads(
            vehicle.identity.vehicle_id,
            files.scans,
            self._http,
            lambda text: signature_text(key, text),
            self._report_event,
            self._ask_for_scans,
        )
        self._videos = VideoUploads(
            vehicle_id, files.video / "outgoing", self._http, lambda text: signature_text(key, text)
        )
        self._marks = None
        cameras = vehicle.mail / "video"
        if files.cameras() is not None:
            self._marks = VideoMarks(lambda mark: self._mailbox.post(cameras, mark))
        self._cameras = CameraRequests(
            vehicle.clock,
            None if self._marks is None else lambda request: self._mailbox.post(cameras, request),
            self._show_picture,
        )
        self._scan_maps = None
        if vehicle.identity.localizes_by:
            self._scan_maps = LocalizationChanger(
                vehicle.identity.vehicle_id,
                files,
                self._http,
                lambda text: signature_text(key, text),
                self._report_event,
                self._offer_localization_map,
            )
        url = config.server_url.replace("http", "ws", 1) + "/ws/vehicle"
        self._client = LinkClient(
            url,
            self._bridge,
            self._deliver,
            self._clock.now_ns,
            self._tls,
            map_published=self._maps.announced,
            scans_requested=self._scans.requested,
            localization_map_published=None if self._scan_maps is None else self._scan_maps.announced,
        )

    async def run(self) -> None:
        """Runs until cancelled; then finishes and uploads the open segment."""
        asyncio.get_running_loop().add_reader(self._mailbox.fileno(), self._collect)
        self._queue_earlier_segments()
        try:
            async with asyncio.TaskGroup() as tasks:
                tasks.create_task(self._connect_when_ready())
                tasks.create_task(self._process_reports())
                tasks.create_task(self._uploader.run())
                tasks.create_task(self._maps.run())
                tasks.create_task(self._scans.run())
                tasks.create_task(self._videos.run())
                if self._scan_maps is not None:
                    tasks.create_task(self._scan_maps.run())
        finally:
            asyncio.get_running_loop().remove_reader(self._mailbox.fileno())
            self._write_log(self._log_files.close)
            for segment in self._log_files.take_finished():
                await self._uploader.upload(Path(segment.path), segment.sha256)
            self._bridge.close()
            self._mailbox.close()
            await self._http.aclose()

    async def _connect_when_ready(self) -> None:
        """Connects once the tick can take the server's messages."""
        await self._tick_is_up.wait()
        await self._client.run()

    def _collect(self) -> None:
        for mail in self._mailbox.take():
            if isinstance(mail, TracedSpans) and self._spans is not None:
                for span in mail.spans:
                    self._spans.add(span)
            if isinstance(mail, MapAnswer):
                self._take_map_answer(mail)
            if isinstance(mail, ScanReports):
                self._scans.kept(tuple(_scans_reported(one) for one in mail.reports))
            if isinstance(mail, LocalizationMapAnswer):
                self._take_localization_answer(mail)
            if isinstance(mail, CameraShown):
                self._show_picture(mail.picture)
            if not isinstance(mail, TickReport):
                continue
            if self._scans.areas:
                self._mailbox.post(self._keeper, track_of(mail))
            if self._marks is not None:
                self._marks.pass_on(mail.entries)
            self._notice_boot(mail)
            self._tick_is_up.set()
            if self._reports.full():
                log.error("link.tick_report_lost", vehicle_id=self._identity.vehicle_id)
            else:
                self._reports.put_nowait(mail)

    def _notice_boot(self, report: TickReport) -> None:
        """Reconnects after a restart of the tick: it has no grants, and a new hello brings them.

        Also after a change of the map, with which another run begins: the hello names it.
        """
        for entry in report.entries:
            if isinstance(entry, SegmentBegin) and entry.header.boot_id != self._tick_boot_id:
                session, header = self._bridge.session, entry.header
                compared = "" if header.localization_map == NO_LOCALIZATION_MAP else header.localization_map
                if self._scan_maps is not None:
                    self._scan_maps.taken(compared)
                session.identity = msgspec.structs.replace(
                    session.identity,
                    map_version=header.map_version,
                    run_boot_id=header.boot_id,
                    localization_map=compared,
                )
                if self._tick_boot_id:
                    self._client.reconnect()
                self._tick_boot_id = entry.header.boot_id

    async def _process_reports(self) -> None:
        while True:
            report = await self._reports.get()
            if report.update is not None:
                await self._process_update(report.update)
            if report.entries:
                write = partial(self._log_files.write, list(report.entries))
                await asyncio.to_thread(self._write_log, write)
                for segment in self._log_files.take_finished():
                    self._uploader.add(Path(segment.path), segment.sha256)

    async def _process_update(self, update: TickUpdate) -> None:
        lines = self._bridge.number_events(update)
        if lines or update.memory is not None:
            await self._write(update, lines)
        self._bridge.send(update, self._clock.now_ns())
        if self._tracing is not None:
            self._tracing.answered(update.answers, self._clock.now_ns() + self._utc_offset_ns)
        self._client.wake()

    async def _write(self, update: TickUpdate, lines: bytes) -> None:
        """Until it is on the disk: an event is not sent before, and none is lost while a disk is full."""
        while True:
            try:
                await asyncio.to_thread(self._bridge.write, update, lines)
                return
            except OSError as error:
                log.error("outbox.not_written", vehicle_id=self._identity.vehicle_id, error=str(error))
            await asyncio.sleep(WRITE_AGAIN_S)

    def _write_log(self, write: Callable[[], None]) -> None:
        """Without a recording a vehicle drives on, and the next segment is tried again."""
        try:
            write()
        except OSError as error:
            log.error("run.not_recorded", vehicle_id=self._identity.vehicle_id, error=str(error))
            self._log_files.give_up()

    def _ask_for_scans(self, areas: tuple[ScanArea, ...]) -> None:
        self._mailbox.post(self._keeper, ScanWork(areas))

    def _offer_map(self, map_version: str) -> None:
        self._mailbox.post(self._tick, MapOffer(map_version))

    def _take_map_answer(self, answer: MapAnswer) -> None:
        if answer.refusal is None:
            self._maps.taken(answer.map_version)
        else:
            self._maps.refused(answer.map_version, MapNotTaken(answer.refusal, answer.detail))

    def _offer_localization_map(self, map_version: str) -> None:
        self._mailbox.post(self._tick, LocalizationMapOffer(map_version))

    def _take_localization_answer(self, answer: LocalizationMapAnswer) -> None:
        if self._scan_maps is None:
            return
        if answer.refusal is None:
            self._scan_maps.taken(answer.map_version)
        else:
            refusal = LocalizationMapNotTaken(answer.refusal, answer.detail)
            self._scan_maps.refused(answer.map_version, refusal)

    async def _report_event(self, event: VehicleEvent) -> None:
        """An event of the link's own, in the order of those of the tick."""
        await self._reports.put(TickReport(TickUpdate(self._clock.now_ns(), events=(event,)), ()))

    def _show_picture(self, picture: CameraPicture) -> None:
        self._bridge.session.show(picture)
        self._client.wake()

    def _deliver(self, message: LinkMessage) -> None:
        if isinstance(message, Command):
            self._cameras.hear(message)
        delivery = Delivery(self._clock.now_ns(), "link", message)
        if self._tracing is not None:
            self._tracing.received(message, delivery.arrival_ns + self._utc_offset_ns)
        if not self._mailbox.post(self._tick, Deliveries((delivery,))):
            log.warning("link.word_lost", vehicle_id=self._identity.vehicle_id, word=type(message).__name__)

    def _queue_earlier_segments(self) -> None:
        """Queues what an earlier link left, finished or cut short, before this one writes; the server stores
        each segment once.
        """
        for path in sorted(self._runs.glob("*/*.mcap")):
            segment = finished_segment(path, int(path.stem))
            self._uploader.add(path, segment.sha256)


def _scans_reported(report: RequestReport) -> ScansReported:
    totals = report.totals
    return ScansReported(
        report.request_id, report.state, totals.scans, totals.way_m, totals.bytes_kept, report.detail
    )


def _tls_context(server_url: str, certificate: str) -> ssl.SSLContext | None:
    if not server_url.startswith("https"):
        return None
    return ssl.create_default_context(cafile=certificate or None)


async def serve_links(vehicles: list[LinkedVehicle]) -> None:
    """Runs the links of these vehicles until SIGTERM."""
    stop = asyncio.Event()
    asyncio.get_running_loop().add_signal_handler(signal.SIGTERM, stop.set)
    links = [asyncio.create_task(VehicleLink(vehicle).run()) for vehicle in vehicles]
    stopped = asyncio.create_task(stop.wait())
    await asyncio.wait([*links, stopped], return_when=asyncio.FIRST_COMPLETED)
    for task in links:
        task.cancel()
    for ended in await asyncio.gather(*links, return_exceptions=True):
        if isinstance(ended, BaseException) and not isinstance(ended, asyncio.CancelledError):
            raise ended
