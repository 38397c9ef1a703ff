"""Marks in recordings, and recordings that operators start and stop."""

from collections.abc import Sequence
from datetime import datetime
from typing import Literal

from pydantic import BaseModel, ConfigDict, Field
from pydantic.config import JsonDict

from server.api.formats import FreeText
from server.api.runs.schemas import SegmentView, segment_view
from server.domain.record.recordings import Recording
from server.domain.record.runs import Segment
from server.usecases.record.recordings import is_kept

MARK_EXAMPLE: JsonDict = {
    "mark_id": "command-12",
    "kind": "mark",
    "at_ms": 1_788_250_502_000,
    "note": "Braked for a shadow?",
    "by": "ines",
    "state": "done",
    "in_file": True,
}
RECORDING_EXAMPLE: JsonDict = {
    "recording_id": "command-9",
    "command_id": "command-11",
    "vehicle_id": "shuttle-1",
    "name": "Crossing at the library, rain",
    "state": "kept",
    "detail": "",
    "started_at": "2026-09-01T08:14:31Z",
    "started_by": "ines",
    "stopped_at": "2026-09-01T08:19:02Z",
    "stopped_by": "ines",
    "boot_id": "boot-7a1e",
    "segments": [],
}


class NewMark(BaseModel):
    model_config = ConfigDict(extra="forbid", json_schema_extra={"example": {"note": "Braked for a shadow?"}})

    note: FreeText = Field(min_length=1)


class NewRecording(BaseModel):
    model_config = ConfigDict(
        extra="forbid", json_schema_extra={"example": {"name": "Crossing at the library, rain"}}
    )

    name: FreeText = Field(min_length=1)


class RunMark(BaseModel):
    """A mark of an operator in a run, or where a recording begins or ends.

    The server knows of it at once. The vehicle writes it into the run's file when it hears of it.
    """

    model_config = ConfigDict(json_schema_extra={"example": MARK_EXAMPLE})

    mark_id: str
    kind: Literal["mark", "start_recording", "stop_recording"]
    at_ms: int = Field(description="The marked moment, Unix time.")
    note: str
    by: str = Field(description="Empty if this server does not know the mark but from the file.")
    state: Literal["pending", "done", "failed"] = Field(
        description="pending: the vehicle has not heard of it yet; it may be out of reach."
    )
    in_file: bool = Field(description="It is in a file that has been uploaded.")


class RecordingView(BaseModel):
    """A named span of what the vehicle records always. It begins and ends with a file of its own.

    waiting, stopping: the vehicle has not answered yet; it may be out of reach. ended: not all of its files
    have been uploaded; kept: all have.
    """

    model_config = ConfigDict(json_schema_extra={"example": RECORDING_EXAMPLE})

    recording_id: str
    command_id: str = Field(description="Of the newest command: the one that started or stopped it.")
    vehicle_id: str
    name: str
    state: Literal["waiting", "refused", "running", "stopping", "ended", "kept"]
    detail: str = Field(description="The vehicle's reason when it refused; empty otherwise.")
    started_at: datetime
    started_by: str
    stopped_at: datetime | None
    stopped_by: str
    boot_id: str = Field(description="Of the run in which it begins; empty until one of its files has come.")
    segments: list[SegmentView] = Field(description="Its files so far, in order.")


def recording_view(recording: Recording, files: Sequence[Segment]) -> RecordingView:
    return RecordingView(
        recording_id=recording.recording_id,
        command_id=recording.stop_id or recording.recording_id,
        vehicle_id=recording.vehicle_id,
        name=recording.name,
        state="kept" if is_kept(recording, files) else recording.state,
        detail=recording.detail,
        started_at=recording.started_at,
        started_by=recording.started_by,
        stopped_at=recording.stopped_at,
        stopped_by=recording.stopped_by,
        boot_id=files[0].boot_id if files else "",
        segments=[segment_view(one) for one in files],
    )
