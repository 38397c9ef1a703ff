"""Four cameras of 640x480 at 10 Hz recorded beside a driving loop.

    python -m benchmarks.video --minutes 10 --json F

A drive is a process at 50 Hz on the wall clock, with the priority of a vehicle's tick if the system allows it
(is_real_time). In the first one the recorder runs and stands still in turn:
other work on the machine meets the ticks of both kinds alike. In the second one it runs all the time, and
every picture that was written is looked for in the files. Then recorders are killed, and their files decoded.
The pictures are those of the simulator's cameras.
"""

import argparse
import os
import tempfile
import time
from pathlib import Path

import numpy as np

from benchmarks.reporting.report import Row, RunReport
from benchmarks.video.pictures import rendered
from benchmarks.video.trials import Driving, alternating, lost_pictures, recording, seconds_lost
from contract.roads.load import load_map

SHIPPED = Path(__file__).resolve().parents[2] / "maps" / "shanghai-university" / "map.json"
# Of one kind; after its begin the caches are not yet those of its kind.
WINDOW_S = 5.0
SETTLE_NS = 500_000_000


def main() -> None:
    report, arguments = RunReport(), _arguments()
    load_before = os.getloadavg()[0]
    with tempfile.TemporaryDirectory() as text:
        folder = Path(text)
        pictures = folder / "pictures.npz"
        shots = rendered(load_map(arguments.map), arguments.seed, arguments.pictures)
        np.savez(pictures, **shots)
        print(f"{arguments.pictures} pictures of each camera rendered", flush=True)
        rows, summary = with_and_without(arguments, folder, pictures)
        if arguments.minutes:
            more, further = beside_a_drive(arguments, folder, pictures)
            rows, summary = [*rows, *more], {**summary, **further}
        lost_s = kills(arguments, folder, pictures)
    rows += [{"part": f"kill {number + 1}", "lost_s": lost} for number, lost in enumerate(lost_s)]
    summary = {
        **summary,
        "kill_lost_s": max(lost_s, default=None),
        "load_before": load_before,
        "load_after": os.getloadavg()[0],
    }
    arguments_written = {
        "map": arguments.map.name, "minutes": arguments.minutes, "paired_minutes": arguments.paired_minutes,
        "kills": arguments.kills,
        "pictures": arguments.pictures, "seed": arguments.seed,
    }  # fmt: skip
    report.write(arguments.json, "video", arguments_written, rows, summary)


def beside_a_drive(arguments: argparse.Namespace, folder: Path, pictures: Path) -> tuple[list[Row], Row]:
    """Recorded without a pause: cores, and every picture looked for in the files."""
    with recording(folder / "beside", pictures, arguments.seed, 60) as recorded:
        recorded.begin_count()
        driving = Driving(arguments.map, folder / "drive", arguments.seed, 60.0 * arguments.minutes)
        ticks_ms = driving.ticks()[:, 1] / 1e6
        recorded.end_count()
        ended_ns = time.monotonic_ns()
        # The last pictures are on their way.
        time.sleep(1.0)
    written, lost = lost_pictures(recorded, ended_ns)
    size_bytes = sum(file.stat().st_size for file in recorded.folder.glob("*.webm"))
    row: Row = {"part": "recorded all the time", **_quantiles(ticks_ms)}
    summary: Row = {
        "recorder_cores": recorded.cpu_s / recorded.wall_s,
        "recorded_s": recorded.wall_s,
        "pictures": written,
        "pictures_lost": lost,
        "kilobytes_a_second": size_bytes / 1e3 / recorded.wall_s,
    }
    return [row], summary


def with_and_without(arguments: argparse.Namespace, folder: Path, pictures: Path) -> tuple[list[Row], Row]:
    """One drive; the recorder runs and stands still in turn."""
    with recording(folder / "in-turn", pictures, arguments.seed, 60) as recorded:
        driving = Driving(arguments.map, folder / "turns", arguments.seed, 60.0 * arguments.paired_minutes)
        windows = alternating(driving, recorded, WINDOW_S)
        ticks = driving.ticks()
    found: dict[bool, list[np.ndarray]] = {True: [], False: []}
    for begin_ns, end_ns, is_on in windows:
        inside = (ticks[:, 0] >= begin_ns + SETTLE_NS) & (ticks[:, 0] < end_ns)
        found[is_on].append(ticks[inside, 1] / 1e6)
    beside, alone = np.concatenate(found[True]), np.concatenate(found[False])
    rows: list[Row] = [
        {"part": "windows with", **_quantiles(beside)},
        {"part": "windows without", **_quantiles(alone)},
    ]
    p99, p99_without = float(np.percentile(beside, 99)), float(np.percentile(alone, 99))
    summary: Row = {
        "tick_p99_ms": p99,
        "tick_p99_without_ms": p99_without,
        "tick_p99_ratio": p99 / p99_without,
        "is_real_time": driving.is_real_time,
    }
    return rows, summary


def _quantiles(ticks_ms: np.ndarray) -> Row:
    return {
        "ticks": len(ticks_ms),
        **{f"p{quantile}_ms": float(np.percentile(ticks_ms, quantile)) for quantile in (50, 95, 99)},
    }


def kills(arguments: argparse.Namespace, folder: Path, pictures: Path) -> list[float]:
    """Seconds lost at each kill, at a moment of the second that is drawn from the seed."""
    rng, found = np.random.default_rng(arguments.seed), []
    for number in range(arguments.kills):
        with recording(folder / f"kill-{number}", pictures, arguments.seed, 60) as recorded:
            time.sleep(float(rng.uniform(4.0, 7.0)))
            killed_ns = recorded.kill()
        found.append(seconds_lost(recorded.folder, killed_ns))
    return found


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--json", type=Path, help="write the report here")
    parser.add_argument("--map", type=Path, default=SHIPPED, help="campus map to drive on")
    parser.add_argument("--minutes", type=float, default=10.0, help="of recording all the time; 0: none")
    parser.add_argument("--paired-minutes", type=float, default=4.0, help="of recording in turn")
    parser.add_argument("--kills", type=int, default=5)
    parser.add_argument(
        "--pictures", type=int, default=40, help="rendered of each camera, played forth and back"
    )
    parser.add_argument("--seed", type=int, default=1)
    return parser.parse_args()


if __name__ == "__main__":
    main()
