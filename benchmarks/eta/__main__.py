"""How often a shuttle comes, and arrives, within the range of times that its passenger is shown.

    python -m benchmarks.eta [--seeds 1 2 3] [--held-out 101 102 103] [--hours 1] [--json FILE]

The simulated service (`campusloop simulate-service`) runs without faults: 20 shuttles, 120 bookings an
hour, passengers who are slow, cancel and change their minds, operators who hold and recall shuttles and close
roads. Once a minute, every range that a waiting passenger is shown is noted; when the party has boarded, each
is compared with that. So are the ranges of arrivals that parties aboard are shown. The tables of
`server/domain/planning/eta_ranges.py` were tuned on --seeds; the summary is of the others:

    eta_inside_pct         of the ranges shown, how many held the pickup
    eta_inside_near_pct    of those shown in the last 10 minutes before the planned pickup
    eta_inside_first_pct   of the first range that each party was shown
    eta_width_s            mean width; eta_width_near_s: in the last 10 minutes
    eta_inside_tuned_pct   as the first, on the seeds that the table was tuned on
    eta_arrival_inside_pct, eta_arrival_width_s, eta_arrival_inside_tuned_pct  the same of arrivals
    eta_waiting_arrival_inside_pct, _first_pct, _width_s, _tuned_pct  of arrivals, shown to parties that wait
"""

import argparse
import tempfile
from collections.abc import Sequence
from pathlib import Path
from statistics import fmean

import structlog

from benchmarks.eta.shown_ranges import ShownRange, SimulatedHours, shown_ranges
from benchmarks.reporting.report import Row, RunReport
from campusloop.kernels.compiling import ensure_kernels
from campusloop.kernels.groups import SERVER, for_vehicle
from campusloop.shipped import DEFAULT_MAP
from contract.roads.load import load_map

_NEAR_S = 600.0
_STANDINGS = ("early", "on_time", "behind")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--seeds", type=int, nargs="+", default=[1, 2, 3], help="that the table was tuned on")
    parser.add_argument("--held-out", type=int, nargs="+", default=[101, 102, 103])
    parser.add_argument("--hours", type=float, default=1.0, help="virtual hours of bookings for each seed")
    parser.add_argument("--json", type=Path, default=None)
    arguments = parser.parse_args()
    ensure_kernels((*SERVER, *for_vehicle("gem")))
    structlog.configure(processors=[_drop])
    report = RunReport()
    tuned = {seed: _simulated(seed, arguments.hours) for seed in arguments.seeds}
    held_out = {seed: _simulated(seed, arguments.hours) for seed in arguments.held_out}
    runs = tuned | held_out
    rows = [_row(f"seed {seed}", run.ranges) for seed, run in runs.items()]
    rows += [_row(f"seed {seed}, arrivals", run.arrivals) for seed, run in runs.items()]
    others = [one for run in held_out.values() for one in run.ranges]
    arrivals = [one for run in held_out.values() for one in run.arrivals]
    rows += [_row(f"seed {seed}, arrivals of who waits", run.waiting) for seed, run in runs.items()]
    rows += [_row(f"held out, {name}", [r for r in others if r.standing == name]) for name in _STANDINGS]
    waiting = [one for run in held_out.values() for one in run.waiting]
    near = [one for one in others if one.ahead_s <= _NEAR_S]
    summary: Row = {
        "eta_inside_pct": inside_pct(others),
        "eta_inside_near_pct": inside_pct(near),
        "eta_inside_first_pct": inside_pct(first_of_each(others)),
        "eta_width_s": _width_s(others),
        "eta_width_near_s": _width_s(near),
        "eta_inside_tuned_pct": inside_pct([one for run in tuned.values() for one in run.ranges]),
        "eta_arrival_inside_pct": inside_pct(arrivals),
        "eta_arrival_width_s": _width_s(arrivals),
        "eta_arrival_inside_tuned_pct": inside_pct([r for run in tuned.values() for r in run.arrivals]),
        "eta_waiting_arrival_inside_pct": inside_pct(waiting),
        "eta_waiting_arrival_first_pct": inside_pct(first_of_each(waiting)),
        "eta_waiting_arrival_width_s": _width_s(waiting),
        "eta_waiting_arrival_tuned_pct": inside_pct([r for run in tuned.values() for r in run.waiting]),
    }
    given = {"seeds": arguments.seeds, "held_out": arguments.held_out, "hours": arguments.hours}
    report.write(arguments.json, "eta", given, rows, summary)


def inside_pct(ranges: Sequence[ShownRange]) -> float | None:
    """None where there are none."""
    return 100.0 * fmean(one.is_inside for one in ranges) if ranges else None


def first_of_each(ranges: Sequence[ShownRange]) -> list[ShownRange]:
    """The first range that each party was shown; ranges of one run in order of time."""
    found: dict[str, ShownRange] = {}
    for one in ranges:
        found.setdefault(one.ride_id, one)
    return list(found.values())


def _width_s(ranges: Sequence[ShownRange]) -> float | None:
    return fmean(one.width_s for one in ranges) if ranges else None


def _row(name: str, ranges: Sequence[ShownRange]) -> Row:
    return {
        "what": name,
        "rides": len({one.ride_id for one in ranges}),
        "ranges": len(ranges),
        "inside_pct": inside_pct(ranges),
        "first_inside_pct": inside_pct(first_of_each(ranges)),
        "before_pct": 100.0 * fmean(r.came < r.shown.earliest for r in ranges) if ranges else None,
        "width_s": _width_s(ranges),
    }


def _simulated(seed: int, hours: float) -> SimulatedHours:
    """Prints the rules that the service broke meanwhile."""
    with tempfile.TemporaryDirectory() as folder:
        simulated = shown_ranges(load_map(DEFAULT_MAP), Path(folder), seed, hours)
    for violation in simulated.violations:
        print(f"seed {seed}: {violation}")
    return simulated


def _drop(_logger: object, _method: str, _event: structlog.typing.EventDict) -> structlog.typing.EventDict:
    raise structlog.DropEvent


if __name__ == "__main__":
    main()
