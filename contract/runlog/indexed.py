"""Read a few topics of a segment by its index: minutes of driving without the ticks in between."""

import io
import struct
from collections.abc import Collection, Iterator
from pathlib import Path

import msgspec
import zstandard
from mcap.exceptions import McapError
from mcap.reader import SeekingReader

from contract.runlog.reader import MCAP_MAGIC, LoggedMessage, RunLogError, messages
from contract.runlog.records import MARK_TOPIC, RecordingMark


def messages_of(
    path: Path, topics: Collection[str], from_ns: int = 0, to_ns: int | None = None
) -> Iterator[LoggedMessage]:
    """Every message of these topics with from_ns <= log time < to_ns, in order of log time.

    Of a finished segment only the chunks that hold some are read. One that a kill cut short has no index and
    is read whole. Raises RunLogError like `reader.messages`.
    """
    if not _is_finished(path):
        yield from (one for one in messages(path, from_ns, to_ns) if one.topic in topics)
        return
    last_ns = 0
    try:
        with path.open("rb") as stream:
            reader = SeekingReader(stream, validate_crcs=True)
            found = reader.iter_messages(topics=list(topics), starting_at=from_ns, ending_before=to_ns)
            for _, channel, message in found:
                last_ns = message.log_time
                yield LoggedMessage(channel.topic, message.log_time, message.data)
    except (McapError, zstandard.ZstdError, struct.error, ValueError, OverflowError, MemoryError) as error:
        detail = f"{path}: damaged after log time {last_ns} ns ({error}); use the copy on the server"
        raise RunLogError("damaged", detail, last_ns) from error


def marks(path: Path) -> Iterator[RecordingMark]:
    """Operators' marks, in the order in which they reached the vehicle; raises like `messages_of`."""
    return (mark for _, mark in logged_marks(path))


def logged_marks(path: Path) -> Iterator[tuple[int, RecordingMark]]:
    """(log time in UTC ns, mark): when each reached the vehicle; raises like `messages_of`."""
    decoder = msgspec.json.Decoder(RecordingMark)
    for message in messages_of(path, (MARK_TOPIC,)):
        try:
            yield message.log_ns, decoder.decode(message.data)
        except msgspec.DecodeError as error:
            detail = f"{path}: a mark cannot be read ({error})"
            raise RunLogError("damaged", detail, message.log_ns) from error


def _is_finished(path: Path) -> bool:
    """The file was closed, and ends with its index. Raises RunLogError `missing`."""
    try:
        with path.open("rb") as stream:
            size = stream.seek(0, io.SEEK_END)
            stream.seek(max(0, size - len(MCAP_MAGIC)))
            return size > 2 * len(MCAP_MAGIC) and stream.read() == MCAP_MAGIC
    except FileNotFoundError as error:
        raise RunLogError("missing", f"no run log at {path}") from error
