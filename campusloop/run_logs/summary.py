"""What happened in a run: how far it went, which events there were, and how it ended."""

from collections import Counter
from dataclasses import dataclass

import msgspec

from campusloop.run_logs.folders import RecordedRun
from contract.runlog.reader import RunLogError, messages
from contract.runlog.records import EVENT_TOPIC, REPORT_TOPIC
from contract.wire.messages import Status

# Reports come at 5 Hz. Between two that are further apart something is missing, and the way is not known.
REPORT_GAP_NS_MAX = 1_000_000_000
STANDING_MPS = 0.05


class _EventName(msgspec.Struct):
    """The part of an event that is counted."""

    event: str


@dataclass(frozen=True, slots=True)
class RunSummary:
    """distance_m  the measured speed over time; what lies in gaps of more than a second is not in it
    events         how many of each kind, the most frequent first
    last           the newest status, None without any
    defects        what is wrong with each file that is not sound to its end; the sound part is counted
    """

    distance_m: float
    events: dict[str, int]
    last: Status | None
    defects: tuple[RunLogError, ...]


def run_summary(run: RecordedRun) -> RunSummary:
    """Read the whole run."""
    statuses = msgspec.json.Decoder(Status)
    names = msgspec.json.Decoder(_EventName)
    events: Counter[str] = Counter()
    defects: list[RunLogError] = []
    distance_m, last, last_ns = 0.0, None, 0
    for path in run.paths:
        try:
            for message in messages(path):
                if message.topic == EVENT_TOPIC:
                    events[names.decode(message.data).event] += 1
                elif message.topic == REPORT_TOPIC:
                    status = statuses.decode(message.data)
                    if last is not None and message.log_ns - last_ns <= REPORT_GAP_NS_MAX:
                        mean_mps = (abs(last.speed_mps) + abs(status.speed_mps)) / 2.0
                        distance_m += mean_mps * (message.log_ns - last_ns) * 1e-9
                    last, last_ns = status, message.log_ns
        except RunLogError as error:
            defects.append(error)
    return RunSummary(distance_m, dict(events.most_common()), last, tuple(defects))


def ending(summary: RunSummary) -> str:
    """How the recording ends, in a sentence without a full stop."""
    last = summary.last
    if last is None:
        return "before the vehicle's first report"
    moves = abs(last.speed_mps) >= STANDING_MPS
    text = f"driving at {abs(last.speed_mps):.1f} m/s" if moves else "standing"
    text += f", {last.mode.replace('_', ' ')}"
    if last.hold_reason is not None:
        text += (
            f" ({last.hold_reason.replace('_', ' ')}{': ' + last.hold_detail if last.hold_detail else ''})"
        )
    if last.aboard:
        text += f", {len(last.aboard)} {'ride' if len(last.aboard) == 1 else 'rides'} aboard"
    if last.faults:
        text += f", faults: {', '.join(fault.code for fault in last.faults)}"
    return text
