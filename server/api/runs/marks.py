"""The marks of a run: those that are in its files, and those that the server has and no file yet."""

from collections.abc import Sequence
from datetime import datetime
from pathlib import Path
from typing import Literal

from contract.runlog.indexed import marks
from contract.runlog.reader import RunLogError, open_segment
from server.api.recordings.schemas import RunMark
from server.domain.fleet.vehicles import CommandState
from server.domain.instants import moment_of_ns, ms_of
from server.domain.record.recordings import Recording
from server.domain.record.runs import Run
from server.usecases.ports.unit_of_work import UnitOfWork

Span = tuple[datetime, datetime]
MarkKind = Literal["mark", "start_recording", "stop_recording"]


def run_span(run: Run, paths: Sequence[Path]) -> Span | None:
    """From when to when the run has been uploaded, by the clock that its first file has; None without one."""
    if not paths or not run.segments:
        return None
    try:
        offset_ns = open_segment(paths[0]).header.utc_offset_ns
    except RunLogError:
        return None
    first_ns = min(segment.first_ns for segment in run.segments)
    last_ns = max(segment.last_ns for segment in run.segments)
    return moment_of_ns(first_ns + offset_ns), moment_of_ns(last_ns + offset_ns)


def known_marks(uow: UnitOfWork, vehicle_id: str, span: Span) -> list[RunMark]:
    """The server's own of that time."""
    since, until = span
    found = [
        _known(command.command_id, "mark", command.made_at, command.text, command.by, command.state)
        for command in uow.vehicles.marks(vehicle_id, since, until)
    ]
    for recording in uow.recordings.of_time(vehicle_id, since, until):
        found += _ends(recording)
    return found


def run_marks(paths: Sequence[Path], known: Sequence[RunMark]) -> list[RunMark]:
    """In order of time. A mark that is in a file and known is told once."""
    merged = {mark.mark_id: mark for mark in known}
    for path in paths:
        try:
            for mark in marks(path):
                one = merged.get(mark.mark_id)
                merged[mark.mark_id] = RunMark.model_validate(
                    {
                        "mark_id": mark.mark_id,
                        "kind": mark.name,
                        "at_ms": mark.at_ns // 1_000_000,
                        "note": mark.message,
                        "by": "" if one is None else one.by,
                        "state": "done",
                        "in_file": True,
                    }
                )
        except RunLogError as error:
            if error.code not in ("truncated", "damaged"):
                raise
    return sorted(merged.values(), key=lambda mark: (mark.at_ms, mark.mark_id))


def _ends(recording: Recording) -> list[RunMark]:
    """Its beginning, and its end if it was stopped."""
    refused = recording.state == "refused"
    begun: CommandState = "failed" if refused else "pending" if recording.begun is None else "done"
    name, started_by = recording.name, recording.started_by
    found = [_known(recording.recording_id, "start_recording", recording.started_at, name, started_by, begun)]
    if recording.stop_id and recording.stopped_at is not None:
        ended: CommandState = "pending" if recording.ended is None else "done"
        stopped_at, stopped_by = recording.stopped_at, recording.stopped_by
        found.append(_known(recording.stop_id, "stop_recording", stopped_at, name, stopped_by, ended))
    return found


def _known(mark_id: str, kind: MarkKind, at: datetime, note: str, by: str, state: CommandState) -> RunMark:
    """What the server knows, whether or not it is in a file."""
    return RunMark(mark_id=mark_id, kind=kind, at_ms=ms_of(at), note=note, by=by, state=state, in_file=False)
