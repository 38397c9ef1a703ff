"""From when to when a segment reaches, without decoding what is in it."""

import struct
from pathlib import Path

from mcap.exceptions import McapError
from mcap.reader import make_reader
from mcap.records import Statistics

from contract.runlog.reader import RunLogError, messages


def extent(path: Path) -> tuple[int, int]:
    """(first, last) log time in ns; (0, 0) for a segment without messages.

    A segment that was closed says so in its summary; one that a kill cut short is read through as far as it
    is sound. Raises RunLogError when it is damaged.
    """
    statistics = _statistics(path)
    if statistics is not None:
        return statistics.message_start_time, statistics.message_end_time
    first_ns = last_ns = 0
    try:
        for message in messages(path):
            first_ns = first_ns or message.log_ns
            last_ns = max(last_ns, message.log_ns)
    except RunLogError as error:
        if error.code != "truncated":
            raise
    return first_ns, last_ns


def _statistics(path: Path) -> Statistics | None:
    """None for a file without a sound footer: cut short, or no segment at all."""
    if not path.exists():
        return None
    with path.open("rb") as file:
        try:
            summary = make_reader(file).get_summary()
        except (McapError, struct.error, ValueError):
            return None
    return None if summary is None else summary.statistics
