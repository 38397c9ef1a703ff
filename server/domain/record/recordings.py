"""Recordings that operators ask for: named spans of what a vehicle records always."""

from dataclasses import dataclass, replace
from datetime import datetime
from typing import Literal

from contract.wire.messages import CommandKind

RecordingState = Literal["waiting", "refused", "running", "stopping", "ended"]


@dataclass(frozen=True, slots=True)
class VehicleMoment:
    """When the vehicle did it: its boot, and its clock then."""

    boot_id: str
    stamp_ns: int


@dataclass(frozen=True, slots=True)
class Recording:
    """A span of a vehicle's run logs, from one command to another.

    recording_id  the command that started it
    stop_id       the command that stops it, "" before
    state         "waiting" and "stopping": the vehicle has not answered yet; it may be out of reach
    begun, ended  of the vehicle's answers, then of the marks in its files; None before, and if it refused
    detail        the vehicle's reason when it refused
    """

    campus_id: str
    recording_id: str
    vehicle_id: str
    name: str
    started_at: datetime
    started_by: str
    state: RecordingState = "waiting"
    stop_id: str = ""
    stopped_at: datetime | None = None
    stopped_by: str = ""
    begun: VehicleMoment | None = None
    ended: VehicleMoment | None = None
    detail: str = ""

    @property
    def is_open(self) -> bool:
        """It has been asked for, was not refused, and has not been stopped."""
        return self.state in ("waiting", "running")


def answered(recording: Recording, command_id: str, moment: VehicleMoment | None, detail: str) -> Recording:
    """The recording after the vehicle's answer to one of its commands. moment: None if it refused."""
    if command_id == recording.stop_id:
        if moment is None:
            return replace(recording, detail=detail)
        return replace(recording, state="ended", ended=moment)
    if moment is None:
        return replace(recording, state="refused", detail=detail)
    # It may have been stopped before the vehicle heard of either command.
    state: RecordingState = "stopping" if recording.stop_id else "running"
    return replace(recording, state=state, begun=moment)


def found_in_file(recording: Recording, command_id: str, moment: VehicleMoment) -> Recording:
    """The recording after a file has come in which one of its ends is marked.

    The boot of an answer is that of the process that talks with the server. Files have the tick's.
    """
    if command_id == recording.stop_id:
        return replace(recording, ended=moment)
    return replace(recording, begun=moment)


# The commands that begin and end one.
RECORDING_COMMANDS: tuple[CommandKind, ...] = ("start_recording", "stop_recording")
