"""Four cameras of 640x480 at 10 Hz recorded beside a driving loop.

    python -m benchmarks.video --minutes 10 --json F

The same drive (a process at 50 Hz on the wall clock) is driven without, with and again without the recorder;
ticks are compared over the part that all three have. The pictures are those of the simulator's cameras. Every
picture that was written is looked for in the files. Then recorders are killed, and their files decoded.
"""

import argparse
import os
import tempfile
import time
from pathlib import Path

import numpy as np

from benchmarks.reporting.report import Row, RunReport
from benchmarks.video.pictures import rendered
from benchmarks.video.trials import driven, lost_pictures, recording, seconds_lost
from contract.roads.load import load_map

SHIPPED = Path(__file__).resolve().parents[2] / "maps" / "shanghai-university" / "map.json"
# Ticks of the first seconds load what later ones have.
_WARM_TICKS = 500


def main() -> None:
    report, arguments = RunReport(), _arguments()
    load_before = os.getloadavg()[0]
    with tempfile.TemporaryDirectory() as text:
        folder = Path(text)
        pictures = folder / "pictures.npz"
        shots = rendered(load_map(arguments.map), arguments.seed, arguments.pictures)
        np.savez(pictures, **shots)
        print(f"{arguments.pictures} pictures of each camera rendered", flush=True)
        rows, summary = beside_a_drive(arguments, folder, pictures)
        lost_s = kills(arguments, folder, pictures)
    rows += [{"part": f"kill {number + 1}", "lost_s": lost} for number, lost in enumerate(lost_s)]
    summary = {
        **summary,
        "kill_lost_s": max(lost_s),
        "load_before": load_before,
        "load_after": os.getloadavg()[0],
    }
    arguments_written = {
        "map": arguments.map.name, "minutes": arguments.minutes, "kills": arguments.kills,
        "pictures": arguments.pictures, "seed": arguments.seed,
    }  # fmt: skip
    report.write(arguments.json, "video", arguments_written, rows, summary)


def beside_a_drive(arguments: argparse.Namespace, folder: Path, pictures: Path) -> tuple[list[Row], Row]:
    seconds = 60.0 * arguments.minutes
    short_s = max(30.0, seconds / 4.0)
    without = [driven(arguments.map, folder / "before", arguments.seed, short_s)]
    with recording(folder / "beside", pictures, arguments.seed, 60) as recorded:
        recorded.begin_count()
        beside = driven(arguments.map, folder / "during", arguments.seed, seconds)
        recorded.end_count()
        ended_ns = time.monotonic_ns()
        # The last pictures are on their way.
        time.sleep(1.0)
    written, lost = lost_pictures(recorded, ended_ns)
    size_bytes = sum(file.stat().st_size for file in recorded.folder.iterdir())
    without.append(driven(arguments.map, folder / "after", arguments.seed, short_s))
    parts = (("without, before", without[0]), ("with", beside), ("without, after", without[1]))
    compared = {name: ticks[_WARM_TICKS : len(without[0])] for name, ticks in parts}
    rows: list[Row] = [
        {
            "part": name,
            "ticks": len(ticks),
            **{f"p{q}_ms": float(np.percentile(ticks, q)) for q in (50, 95, 99)},
        }
        for name, ticks in compared.items()
    ]
    rows.append(
        {"part": "with, whole drive", "ticks": len(beside), "p99_ms": float(np.percentile(beside, 99))}
    )
    p99_without = float(np.percentile(np.concatenate((compared[parts[0][0]], compared[parts[2][0]])), 99))
    p99 = float(np.percentile(compared["with"], 99))
    summary: Row = {
        "tick_p99_ms": p99,
        "tick_p99_without_ms": p99_without,
        "tick_p99_ratio": p99 / p99_without,
        "recorder_cores": recorded.cpu_s / recorded.wall_s,
        "recorded_s": recorded.wall_s,
        "pictures": written,
        "pictures_lost": lost,
        "kilobytes_a_second": size_bytes / 1e3 / recorded.wall_s,
    }
    return rows, summary


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
    parser.add_argument("--minutes", type=float, default=10.0, help="of recording")
    parser.add_argument("--kills", type=int, default=5)
    parser.add_argument(
        "--pictures", type=int, default=40, help="rendered of each camera, played forth and back"
    )
    parser.add_argument("--seed", type=int, default=1)
    return parser.parse_args()


if __name__ == "__main__":
    main()
