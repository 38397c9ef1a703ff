"""The output of `campusloop simulate --km`: Snow Lion's Table 2, Fig. 8b and Fig. 9."""

import csv
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table

from campusloop.campaigns.campaign import Campaign
from campusloop.scenes.stacks import profile_of
from campusloop.studies.endurance.endurance_run import ShiftFigures, Surroundings, drive_km
from contract.roads.load import load_map
from simulator.scoring.ride_quality import RideQuality, ride_quality

# (what, ours, the paper's)
_SPEED_BIN_KMPH = 0.5
_MARK_COLORS = ("#cc3311", "#117733")
_PAPER = {
    "max speed km/h": "11.76",
    "average speed km/h": "7.41",
    "time at >= 9 km/h %": "47.4",
    "acceleration m/s2": "-1.83 .. 1.12",
    "jerk m/s3": "-1.93 .. 1.84",
    "metres within +-1.93 m/s3 %": "100 (by its range)",
    "metres within -1.83..1.12 m/s2 %": "100 (by its range)",
    "km between a <= -1 m/s2": "0.77",
    "km between takeovers": "13.34",
    "planning p95 ms": "85.1",
    "position error cm, RMS": "-",
    "position error cm, 99 %": "-",
    "contacts": "-",
}


@dataclass(frozen=True, slots=True)
class Summary:
    """The figures of all shifts.

    takeover_km     None without takeovers
    plan_ms_p95     None without a planner
    position_rms_m, position_p99_m  None where no shuttle ever knew where it is
    """

    quality: RideQuality
    shifts: int
    odometer_km: float
    rides_completed: int
    contacts: int
    takeovers: tuple[str, ...]
    takeover_km: float | None
    plan_ms_p95: float | None
    position_rms_m: float | None = None
    position_p99_m: float | None = None


class NoDistanceDriven(Exception):
    """No shuttle has driven; the message says what to change."""


def report_km(
    console: Console,
    campaign: Campaign,
    maps: tuple[Path, ...],
    stack: str,
    km: float,
    seed: int,
    shift_s: float,
    out: Path | None,
    plant_seed: int | None = None,
    surroundings: Mapping[Path, Surroundings] | None = None,
) -> int:
    """Drive, print and write (see `drive_km`). Returns the number of contacts.

    Raises MapError, ProfileError, NoDistanceDriven, CampaignError.
    """
    profile_of(stack)
    for path in maps:
        load_map(path)

    def report(figures: ShiftFigures, so_far_km: float) -> None:
        shift = figures.shift
        console.print(
            f"{shift.map_path.parent.name} shift {shift.number} seed {shift.seed}: "
            f"{figures.distance_m / 1000:.2f} km, {figures.rides_completed} rides, "
            f"{figures.contacts} contacts, {len(figures.takeovers)} takeovers; "
            f"{so_far_km:.2f} of {km:g} km",
            highlight=False,
            soft_wrap=True,
        )

    # With lidars a shift takes about as long as it does in reality: silence would look like a fault.
    console.print(
        f"driving shifts of {shift_s / 60:g} minutes (--shift-s); each says what it was when it ends",
        highlight=False,
        soft_wrap=True,
    )
    shifts = drive_km(campaign, maps, stack, km, seed, shift_s, report, plant_seed, surroundings)
    summary = summary_of(shifts)
    if summary is None:
        raise NoDistanceDriven("nothing was driven in these shifts; give them more time (--shift-s)")
    print_table(console, summary)
    if out is not None:
        write_files(out, shifts, summary)
    return summary.contacts


def summary_of(shifts: list[ShiftFigures]) -> Summary | None:
    """None when nothing was driven."""
    quality = ride_quality([one for figures in shifts for one in figures.stretches])
    if quality is None:
        return None
    takeovers = tuple(text for figures in shifts for text in figures.takeovers)
    odometer_km = sum(figures.distance_m for figures in shifts) / 1000.0
    plan_ms = [value for figures in shifts for value in figures.plan_ms]
    errors_m = np.array([value for figures in shifts for value in figures.position_errors_m])
    return Summary(
        quality,
        len(shifts),
        odometer_km,
        sum(figures.rides_completed for figures in shifts),
        sum(figures.contacts for figures in shifts),
        takeovers,
        odometer_km / len(takeovers) if takeovers else None,
        float(np.percentile(plan_ms, 95)) if plan_ms else None,
        float(np.sqrt(np.mean(errors_m**2))) if len(errors_m) else None,
        float(np.percentile(errors_m, 99)) if len(errors_m) else None,
    )


def print_table(console: Console, summary: Summary) -> None:
    quality = summary.quality
    ours = {
        "max speed km/h": f"{quality.speed_kmph_max:.2f}",
        "average speed km/h": f"{quality.speed_kmph_mean:.2f}",
        "time at >= 9 km/h %": f"{100 * quality.fast_ratio:.1f}",
        "acceleration m/s2": f"{quality.accel_mps2_min:.2f} .. {quality.accel_mps2_max:.2f}",
        "jerk m/s3": f"{quality.jerk_mps3_min:.2f} .. {quality.jerk_mps3_max:.2f}",
        "metres within +-1.93 m/s3 %": f"{100 * quality.jerk_within_ratio:.2f}",
        "metres within -1.83..1.12 m/s2 %": f"{100 * quality.accel_within_ratio:.2f}",
        "km between a <= -1 m/s2": _or_none(quality.braking_km),
        "km between takeovers": _or_none(summary.takeover_km),
        "planning p95 ms": _or_none(summary.plan_ms_p95),
        "position error cm, RMS": _in_cm(summary.position_rms_m),
        "position error cm, 99 %": _in_cm(summary.position_p99_m),
        "contacts": str(summary.contacts),
    }
    table = Table(title=f"Table 2, over {summary.odometer_km:.1f} km", title_justify="left")
    for heading in ("", "here", "paper"):
        table.add_column(heading, justify="right" if heading else "left")
    for name, value in ours.items():
        table.add_row(name, value, _PAPER[name])
    console.print(table)
    for text in summary.takeovers[:20]:
        console.print(f"takeover: {text}", highlight=False)
    console.print(f"{summary.shifts} shifts, {summary.rides_completed} rides completed")


def write_files(folder: Path, shifts: list[ShiftFigures], summary: Summary) -> None:
    """table2.json, speeds.csv, plan_ms.csv, fig8b_speeds.png, fig9_planning.png."""
    folder.mkdir(parents=True, exist_ok=True)
    speeds = 3.6 * np.concatenate([one.speed_mps for figures in shifts for one in figures.stretches])
    plan_ms = np.array([value for figures in shifts for value in figures.plan_ms])
    (folder / "table2.json").write_text(json.dumps(asdict(summary), indent=2, allow_nan=False) + "\n")
    for name, column, values in (("speeds", "speed_kmph", speeds), ("plan_ms", "cpu_ms", plan_ms)):
        with (folder / f"{name}.csv").open("w", newline="", encoding="utf-8") as file:
            rows = csv.writer(file)
            rows.writerow([column])
            rows.writerows([f"{value:.3f}"] for value in values)
    quality = summary.quality
    _histogram(
        folder / "fig8b_speeds.png",
        speeds,
        np.arange(0.0, float(speeds.max()) + _SPEED_BIN_KMPH, _SPEED_BIN_KMPH),
        ("speed (km/h)", "share of the time under way (%)"),
        {
            f"mean {quality.speed_kmph_mean:.1f} (paper 7.41)": quality.speed_kmph_mean,
            f"9 km/h: {100 * quality.fast_ratio:.0f} % at it or above (paper 47.4 %)": 9.0,
        },
    )
    if len(plan_ms):
        p95_ms = float(np.percentile(plan_ms, 95))
        _histogram(
            folder / "fig9_planning.png",
            plan_ms,
            np.linspace(0.0, max(1.0, float(np.percentile(plan_ms, 99.5))), 50),
            ("planning time (ms of CPU); the slowest 0.5 % in the last bar", "share of the plans (%)"),
            {f"95 %: {p95_ms:.1f} ms (paper 85.1 ms)": p95_ms},
        )


def _histogram(
    path: Path, values: np.ndarray, bins: np.ndarray, axis_names: tuple[str, str], marks: dict[str, float]
) -> None:
    """Values beyond the last bin are counted in it. marks: label -> x of a vertical line."""
    # Imported here, because the plotting library is slow to import.
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(6.0, 3.5), layout="constrained")
    axes = figure.add_subplot()
    shown = np.minimum(values, bins[-1])
    axes.hist(shown, bins=list(bins), weights=np.full(len(values), 100.0 / len(values)), color="#4477aa")
    for (name, value), color in zip(marks.items(), _MARK_COLORS, strict=False):
        axes.axvline(value, color=color, linestyle="--", label=name)
    axes.set_xlabel(axis_names[0])
    axes.set_ylabel(axis_names[1])
    axes.set_xlim(left=0.0)
    axes.grid(axis="y", alpha=0.3)
    axes.legend()
    FigureCanvasAgg(figure)
    figure.savefig(path, dpi=150)


def _in_cm(value_m: float | None) -> str:
    return _or_none(None if value_m is None else 100.0 * value_m)


def _or_none(value: float | None) -> str:
    return "none" if value is None else f"{value:.2f}"
