"""The time that a crossing's camera saves (NUS, section V-A, Fig. 12): runs, figures and plots.

Baseline: every cart stops before the crossing and continues when it detects that it is free. With
infrastructure: the cart need not stop if a recent report says that the crossing is empty and the cart detects
the same. Both runs have the same people: their arrivals and positions come from one seed.
"""

from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path

import matplotlib
import numpy as np

from campusloop.campaigns.choice import open_campaign
from campusloop.studies.infrastructure.crossing_loop import CrossingLoop
from vehicle_agent.config import Profile

matplotlib.use("Agg")
from matplotlib import pyplot as plt
from matplotlib.axes import Axes
from matplotlib.figure import Figure

# A run is ended after this multiple of the unhindered time: at 1 person/s a crossing is almost never free.
TIME_FACTOR_MAX = 4.0
FREE_LAP_M = 165.0
COLOURS = ("tab:red", "tab:blue", "tab:green", "tab:orange", "tab:purple", "tab:brown")


@dataclass(frozen=True, slots=True)
class GainCase:
    vehicles: int
    speed_mps: float
    rate_1ps: float
    laps: int
    seed: int


@dataclass(frozen=True, slots=True)
class GainRow:
    """One case. gain_s[k]: T_base - T_infra of lap k, the mean of the carts that finished it in both runs.

    cumulative_s    its sum over laps, for one cart; fleet_s: for all carts together
    laps_finished   the smallest number of any cart, in either run
    contacts        steps of 0.1 s in which a moving cart touched a person, both runs
    """

    vehicles: int
    speed_mps: float
    rate_1ps: float
    laps_finished: int
    gain_s: list[float]
    cumulative_s: list[float]
    fleet_s: list[float]
    base_lap_s: float
    infra_lap_s: float
    contacts: int


def run_case(profile: Profile, case: GainCase) -> GainRow:
    """Both runs of one case."""
    time_max_s = TIME_FACTOR_MAX * case.laps * FREE_LAP_M / case.speed_mps
    laps_s, contacts = [], 0
    for infrastructure in (False, True):
        loop = CrossingLoop(profile, case.vehicles, case.speed_mps, case.rate_1ps, infrastructure, case.seed)
        laps_s.append([np.diff([0.0, *times]) for times in loop.run(case.laps, time_max_s)])
        contacts += loop.contacts
    pairs = [(base, infra) for base, infra in zip(*laps_s, strict=True)]
    common = min(min(len(base), len(infra)) for base, infra in pairs)
    base = np.array([pair[0][:common] for pair in pairs])
    infra = np.array([pair[1][:common] for pair in pairs])
    gains = base - infra
    return GainRow(
        vehicles=case.vehicles,
        speed_mps=case.speed_mps,
        rate_1ps=case.rate_1ps,
        laps_finished=common,
        gain_s=_rounded(gains.mean(axis=0)),
        cumulative_s=_rounded(np.cumsum(gains.mean(axis=0))),
        fleet_s=_rounded(np.cumsum(gains.sum(axis=0))),
        base_lap_s=round(float(base.mean()), 2) if common else float("inf"),
        infra_lap_s=round(float(infra.mean()), 2) if common else float("inf"),
        contacts=contacts,
    )


def run_cases(
    profile: Profile, cases: Sequence[GainCase], workers: int, cluster: str | None = None
) -> Iterable[GainRow]:
    """Rows in the order of the cases. Where they run does not change a row. Raises CampaignError."""
    run = partial(run_case, profile)
    if cluster is None and workers == 1:
        yield from map(run, cases)
        return
    with open_campaign(cluster, workers) as campaign:
        yield from campaign.run(run, cases)


def summary(rows: Sequence[GainRow]) -> dict[str, float]:
    """Gain per lap and cart, and contacts, by case."""
    found: dict[str, float] = {}
    for row in rows:
        key = f"n{row.vehicles}_v{row.speed_mps:g}_lambda{row.rate_1ps:g}"
        found[f"{key}.gain_per_lap_s"] = round(float(np.mean(row.gain_s)), 2) if row.gain_s else 0.0
        found[f"{key}.laps_finished"] = row.laps_finished
    found["contacts"] = sum(row.contacts for row in rows)
    return found


def as_dict(row: GainRow) -> dict[str, object]:
    return asdict(row)


def plot_single(rows: Sequence[GainRow], path: Path) -> None:
    """Fig. 12a: cumulative gain of a single vehicle over laps, a line a speed, a panel a rate."""
    alone = [row for row in rows if row.vehicles == min(r.vehicles for r in rows)]
    rates = sorted({row.rate_1ps for row in alone})
    figure, axes = plt.subplots(1, len(rates), figsize=(4.5 * len(rates), 3.6), squeeze=False)
    for axis, rate in zip(axes[0], rates, strict=True):
        for k, row in enumerate(r for r in alone if r.rate_1ps == rate):
            _line(axis, row.cumulative_s, f"{row.speed_mps:g} m/s", k)
        _name(axis, f"one vehicle, {rate:g} people/s", "cumulative gain, s")
    _save(figure, path)


def plot_fleet(rows: Sequence[GainRow], path: Path) -> None:
    """Fig. 12b: cumulative gain per vehicle over laps, a line a fleet size; panels by speed and rate."""
    rates = sorted({row.rate_1ps for row in rows})
    speeds = sorted({row.speed_mps for row in rows})
    figure, axes = plt.subplots(
        len(speeds), len(rates), figsize=(4.5 * len(rates), 3.4 * len(speeds)), squeeze=False
    )
    for i, speed in enumerate(speeds):
        for j, rate in enumerate(rates):
            chosen = [r for r in rows if r.rate_1ps == rate and r.speed_mps == speed]
            for k, row in enumerate(chosen):
                _line(axes[i][j], row.cumulative_s, f"{row.vehicles} vehicles", k)
            _name(axes[i][j], f"{speed:g} m/s, {rate:g} people/s", "cumulative gain a vehicle, s")
    _save(figure, path)


def _line(axis: Axes, values: Sequence[float], label: str, number: int) -> None:
    # From zero. A case without a finished lap has only its legend entry.
    shown = [0.0, *values] if values else []
    axis.plot(range(len(shown)), shown, marker=".", color=COLOURS[number % len(COLOURS)], label=label)


def _name(axis: Axes, title: str, ylabel: str) -> None:
    axis.set_title(title, fontsize=10)
    axis.set_xlabel("laps")
    axis.set_ylabel(ylabel)
    axis.grid(alpha=0.3)
    axis.axhline(0.0, color="black", linewidth=0.6)
    axis.legend(fontsize=8)


def _save(figure: Figure, path: Path) -> None:
    figure.tight_layout()
    figure.savefig(path, dpi=110)
    plt.close(figure)


def _rounded(values: np.ndarray) -> list[float]:
    return [round(float(value), 3) for value in values]
