"""Which stretches of time operators want to see: their recordings, and a while around each mark. Pure."""

from collections.abc import Iterable

import msgspec

from contract.runlog.records import MarkKind
from contract.video import SegmentName

_S = 1_000_000_000
BEFORE_MARK_NS, AFTER_MARK_NS = 20 * _S, 10 * _S
# A recording that was forgotten is not uploaded for days.
RECORDING_NS_MAX = 3600 * _S
SPANS_MAX = 200


class WantedSpan(msgspec.Struct, frozen=True):
    """By the vehicle's UTC clock. to_ns: None while the recording runs."""

    mark_id: str
    from_ns: int
    to_ns: int | None


class VideoMark(msgspec.Struct, frozen=True, tag="video_mark"):
    """To the process that records video: an operator's mark, or where a recording begins or ends."""

    kind: MarkKind
    at_ns: int
    mark_id: str


def with_mark(spans: tuple[WantedSpan, ...], mark: VideoMark) -> tuple[WantedSpan, ...]:
    """The spans with this mark; a repeat changes nothing. The newest SPANS_MAX are kept."""
    if any(span.mark_id == mark.mark_id for span in spans):
        return spans
    if mark.kind == "stop_recording":
        return tuple(
            msgspec.structs.replace(span, to_ns=max(span.from_ns, mark.at_ns)) if span.to_ns is None else span
            for span in spans
        )
    if mark.kind == "start_recording":
        span = WantedSpan(mark.mark_id, mark.at_ns, None)
    else:
        span = WantedSpan(mark.mark_id, mark.at_ns - BEFORE_MARK_NS, mark.at_ns + AFTER_MARK_NS)
    return (*spans, span)[-SPANS_MAX:]


def wanted(names: Iterable[SegmentName], spans: tuple[WantedSpan, ...]) -> list[SegmentName]:
    """Finished segments with a picture in one of the spans."""
    ends = [
        (span.from_ns, span.from_ns + RECORDING_NS_MAX if span.to_ns is None else span.to_ns)
        for span in spans
    ]
    return [
        name
        for name in names
        if name.length_ms is not None
        and any(name.utc_ns <= to_ns and name.end_utc_ns >= from_ns for from_ns, to_ns in ends)
    ]
