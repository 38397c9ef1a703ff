"""Read segments of a run: whole ones, ones that a kill cut short, and say so of ones that are damaged."""

import io
import struct
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import msgspec
import zstandard
from mcap.exceptions import McapError
from mcap.records import Attachment, Channel, Message, Metadata
from mcap.stream_reader import CRCValidationError, StreamReader

from contract.runlog.records import (
    HEADER_METADATA,
    MAP_ATTACHMENT,
    PROFILE_ATTACHMENT,
    REPORT_TOPIC,
    RUNLOG_VERSION,
    STATE_ATTACHMENT,
    TICK_TOPIC,
    RunHeader,
    TickRecord,
    head_digest,
)
from contract.wire.messages import Status

MCAP_MAGIC = b"\x89MCAP0\r\n"


class RunLogError(Exception):
    """A segment that cannot be used. `after_ns` is the log time of the last sound message, 0 for none."""

    def __init__(self, code: str, detail: str, after_ns: int = 0) -> None:
        super().__init__(detail)
        self.code, self.detail, self.after_ns = code, detail, after_ns


@dataclass(frozen=True, slots=True)
class LoggedMessage:
    topic: str
    log_ns: int
    data: bytes


@dataclass(frozen=True, slots=True)
class Segment:
    """A segment's head; its messages are read as a stream by `messages`."""

    path: Path
    header: RunHeader
    state: bytes
    profile: bytes
    road_map: bytes


def open_segment(path: Path) -> Segment:
    """The head of a segment.

    Raises RunLogError: `missing`, `not_a_run` (no MCAP file of ours), `version`, or `truncated` when the
    kill came before the head was complete.
    """
    parts: dict[str, bytes] = {}
    header: RunHeader | None = None
    for record in _records(path):
        if isinstance(record, Metadata) and record.name == HEADER_METADATA:
            header = _header(path, record.metadata)
        elif isinstance(record, Attachment):
            parts[record.name] = record.data
        if header is not None and len(parts) == 3:
            break
    missing = {STATE_ATTACHMENT, PROFILE_ATTACHMENT, MAP_ATTACHMENT} - parts.keys()
    if header is None or missing:
        raise RunLogError("truncated", f"{path}: the head is incomplete; this segment cannot be used")
    if header.head_sha256 != head_digest(parts.values()):
        raise RunLogError("damaged", f"{path}: an attachment is damaged; use the copy on the server")
    try:
        road_map = zstandard.decompress(parts[MAP_ATTACHMENT])
    except zstandard.ZstdError as error:
        raise RunLogError("damaged", f"{path}: the attached road map is damaged ({error})") from error
    return Segment(path, header, parts[STATE_ATTACHMENT], parts[PROFILE_ATTACHMENT], road_map)


def messages(path: Path, from_ns: int = 0, to_ns: int | None = None) -> Iterator[LoggedMessage]:
    """Every sound message with from_ns <= log time < to_ns, in file order.

    Raises RunLogError `truncated` after the last complete chunk of a file that a kill cut short, and
    `damaged` where a checksum does not match: what came before it has been yielded and is sound.
    """
    topics: dict[int, str] = {}
    for record in _records(path):
        if isinstance(record, Channel):
            topics[record.id] = record.topic
        elif isinstance(record, Message):
            if record.log_time < from_ns or (to_ns is not None and record.log_time >= to_ns):
                continue
            yield LoggedMessage(topics[record.channel_id], record.log_time, record.data)


def ticks(path: Path) -> Iterator[TickRecord]:
    """The segment's tick records in order; raises like `messages`."""
    decoder = msgspec.msgpack.Decoder(TickRecord)
    for message in messages(path):
        if message.topic == TICK_TOPIC:
            try:
                yield decoder.decode(message.data)
            except msgspec.DecodeError as error:
                detail = f"{path}: a tick record cannot be read ({error})"
                raise RunLogError("damaged", detail, message.log_ns) from error


def reports(path: Path, from_ns: int = 0, to_ns: int | None = None) -> Iterator[tuple[int, Status]]:
    """(log time in UTC ns, status) pairs: what a console showed live; raises like `messages`."""
    decoder = msgspec.json.Decoder(Status)
    for message in messages(path, from_ns, to_ns):
        if message.topic == REPORT_TOPIC:
            yield message.log_ns, decoder.decode(message.data)


def _header(path: Path, fields: dict[str, str]) -> RunHeader:
    try:
        header = msgspec.convert(fields, RunHeader, strict=False)
    except msgspec.ValidationError as error:
        raise RunLogError("not_a_run", f"{path}: the run header is not ours ({error})") from error
    if header.version > RUNLOG_VERSION:
        raise RunLogError(
            "version", f"{path} was written by a newer Campusloop (run log {header.version}); update this one"
        )
    if header.version < RUNLOG_VERSION:
        raise RunLogError(
            "version",
            f"{path} was written by an older Campusloop (run log {header.version}, not {RUNLOG_VERSION}); "
            "read it with the version that recorded it",
        )
    return header


def _records(path: Path) -> Iterator[object]:
    """MCAP records, with everything that can be wrong with a file told as a RunLogError."""
    last_ns = 0
    try:
        data = path.read_bytes()
    except FileNotFoundError as error:
        raise RunLogError("missing", f"no run log at {path}") from error
    if not data.startswith(MCAP_MAGIC):
        raise RunLogError("not_a_run", f"{path} is no MCAP file")
    stream = io.BytesIO(data)
    try:
        for record in StreamReader(stream, validate_crcs=True).records:
            if isinstance(record, Message):
                last_ns = record.log_time
            yield record
    except (McapError, zstandard.ZstdError, struct.error, ValueError, OverflowError, MemoryError) as error:
        # The last two are lengths that no memory could hold.
        # A file with its closing magic was finished: what seems to run past its end is a damaged length.
        is_finished = len(data) > 2 * len(MCAP_MAGIC) and data.endswith(MCAP_MAGIC)
        at_end = stream.tell() == len(data) and not isinstance(error, CRCValidationError)
        if at_end and not is_finished:
            detail = f"{path}: ends in the middle of a record after log time {last_ns} ns"
            raise RunLogError("truncated", detail, last_ns) from error
        detail = f"{path}: damaged after log time {last_ns} ns ({error}); use the copy on the server"
        raise RunLogError("damaged", detail, last_ns) from error
