"""The marks of a run: those that are in its files, and those that the server has and no file yet."""

from collections.abc import Sequence
from pathlib import Path

from contract.runlog.indexed import marks
from contract.runlog.reader import RunLogError
from server.api.recordings.schemas import RunMark
from server.domain.fleet.vehicles import CommandState
from server.domain.instants import ms_of
from server.domain.record.recordings import Recording
from server.domain.record.runs import Run
from server.usecases.ports.unit_of_work import UnitOfWork


def known_marks(uow: UnitOfWork, run: Run) -> list[RunMark]:
    """The server's own, while the run was recorded as far as it has been uploaded."""
    if not run.segments:
        return []
    since, until = run.started_at, max(segment.received_at for segment in run.segments)
    found = [
        RunMark(
            mark_id=command.command_id,
            kind="mark",
            at_ms=ms_of(command.made_at),
            note=command.text,
            by=command.by,
            state=command.state,
            in_file=False,
        )
        for command in uow.vehicles.marks(run.vehicle_id, since, until)
    ]
    for recording in uow.recordings.of_time(run.vehicle_id, since, until):
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
    refused = recording.state == "refused"
    begun: CommandState = "failed" if refused else "pending" if recording.begun is None else "done"
    found = [
        RunMark(
            mark_id=recording.recording_id,
            kind="start_recording",
            at_ms=ms_of(recording.started_at),
            note=recording.name,
            by=recording.started_by,
            state=begun,
            in_file=False,
        )
    ]
    if recording.stop_id:
        found.append(
            RunMark(
                mark_id=recording.stop_id,
                kind="stop_recording",
                at_ms=ms_of(recording.stopped_at),
                note=recording.name,
                by=recording.stopped_by,
                state="pending" if recording.ended is None else "done",
                in_file=False,
            )
        )
    return found
