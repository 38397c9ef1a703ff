"""A run as one MCAP file for Foxglove: all of its segments, without what only a replay reads."""

from pathlib import Path

import msgspec
from mcap.writer import CompressionType, Writer

from campusloop.run_logs.folders import RecordedRun
from contract.runlog.reader import RunLogError, messages
from contract.runlog.records import HEADER_METADATA
from contract.runlog.writer import register_json_channels


def write_viewer_file(run: RecordedRun, out: Path) -> tuple[RunLogError, ...]:
    """Write the file, and say what is wrong with each segment that is not sound to its end.

    The ticks and the attached onboard states are left out, so `campusloop replay` needs the segments.
    Raises OSError, FileExistsError among them.
    """
    defects: list[RunLogError] = []
    with out.open("xb") as file:
        writer = Writer(file, compression=CompressionType.ZSTD)
        writer.start(profile="", library=f"campusloop {run.header.software}")
        fields = {key: str(value) for key, value in msgspec.to_builtins(run.header).items()}
        # Not under the name by which a segment is known: this file is none.
        writer.add_metadata(f"{HEADER_METADATA}.export", fields)
        channels = register_json_channels(writer)
        for path in run.paths:
            try:
                for message in messages(path):
                    if message.topic in channels:
                        writer.add_message(
                            channel_id=channels[message.topic],
                            log_time=message.log_ns,
                            publish_time=message.log_ns,
                            data=message.data,
                        )
            except RunLogError as error:
                defects.append(error)
        writer.finish()  # type: ignore[no-untyped-call]
    return tuple(defects)
