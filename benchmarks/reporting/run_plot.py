"""A drive as a picture: `python -m benchmarks.reporting.run_plot TRACE.csv --out FILE.png`.

TRACE.csv is one of those that `--traces DIR` and `campusloop scenario run --out DIR` write, TRACE.agents.csv
lies beside it. Above: the drive seen from above, coloured by speed, with the paths of all agents near it.
Below: its speed, and the clearance between the shuttle's outline and the nearest agent.
"""

import argparse
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

from campusloop.scenes.contact_metrics import clearances
from contract.geometry import Array
from vehicle_agent.config import Body
from vehicle_agent.signals import PEDESTRIAN

NEAR_M = 15.0
OUTLINE_EVERY_S = 5.0
CLEARANCE_SHOWN_M = 6.0
_PEOPLE, _SPEED, _CLEARANCE, _INK = "#c77d0a", "#4477aa", "#cc3311", "#15201b"
_ID, _KIND, _X, _Y, _YAW, _LENGTH, _WIDTH = 1, 2, 3, 4, 5, 6, 7


def main() -> None:
    parser = argparse.ArgumentParser(prog="benchmarks.reporting.run_plot", description=__doc__)
    parser.add_argument("trace", type=Path, help="CSV of the vehicle")
    parser.add_argument("--out", type=Path, required=True, help="PNG or SVG")
    parser.add_argument("--title", default="")
    arguments = parser.parse_args()
    rows = _table(arguments.trace, 7)
    agents = _table(arguments.trace.with_suffix(".agents.csv"), 8)
    plot(rows, agents, Body(), arguments.title).savefig(arguments.out, dpi=110)


def plot(rows: Array, agents: Array, body: Body, title: str = "") -> Figure:
    """rows (n, 7) and agents (m, 8) as in the traces' columns."""
    figure = Figure(figsize=(9.0, 6.0), layout="constrained")
    FigureCanvasAgg(figure)
    above, below = figure.subplots(2, 1, height_ratios=[3, 2])
    above.set_title(title, loc="left")
    _draw_agent_paths(above, rows, agents)
    _draw_drive(figure, above, rows, body)
    above.set_aspect("equal")
    above.set(xlabel="x (m)", ylabel="y (m)")
    below.plot(rows[:, 0], 3.6 * rows[:, 4], color=_SPEED)
    below.set_ylabel("speed (km/h)", color=_SPEED)
    below.set_xlabel("time (s)")
    below.set_ylim(bottom=0.0)
    beside = below.twinx()
    times, clear = clearance_over_time(rows, agents, body)
    beside.plot(times, clear, color=_CLEARANCE)
    beside.axhline(0.0, color=_CLEARANCE, linewidth=0.6, linestyle="--")
    beside.set_ylabel("clearance (m)", color=_CLEARANCE)
    beside.set_ylim(-0.5, CLEARANCE_SHOWN_M)
    return figure


def clearance_over_time(rows: Array, agents: Array, body: Body) -> tuple[Array, Array]:
    """(times, metres) at 10 Hz; NaN without an agent near by."""
    sampled = rows[:: max(1, round(0.1 / max(float(np.diff(rows[:2, 0])[0]), 1e-3)))]
    at = np.round(agents[:, 0], 2)
    out = np.full(len(sampled), np.nan)
    outline = (body.rear_overhang_m, body.front_overhang_m, 0.5 * body.width_m)
    for k, (t, x, y, yaw) in enumerate(sampled[:, :4]):
        here = agents[at == round(float(t), 2)]
        if not len(here):
            continue
        poses = np.ascontiguousarray(here[:, _X : _YAW + 1])
        sizes = np.ascontiguousarray(here[:, _LENGTH : _WIDTH + 1])
        found, _ = clearances(x, y, yaw, *outline, poses, sizes, here[:, _KIND] == PEDESTRIAN)
        out[k] = found.min() if np.isfinite(found.min()) else np.nan
    return sampled[:, 0], out


def _draw_agent_paths(axes: Axes, rows: Array, agents: Array) -> None:
    ways = []
    for number in np.unique(agents[:, _ID]):
        mine = agents[agents[:, _ID] == number]
        own = np.column_stack([np.interp(mine[:, 0], rows[:, 0], rows[:, k]) for k in (1, 2)])
        if np.hypot(*(mine[:, _X : _Y + 1] - own).T).min() <= NEAR_M:
            ways.append(mine[::10, _X : _Y + 1])
    axes.add_collection(LineCollection(ways, colors=_PEOPLE, linewidths=0.6, alpha=0.6))


def _draw_drive(figure: Figure, axes: Axes, rows: Array, body: Body) -> None:
    points = rows[::10, 1:3]
    pieces = LineCollection(np.stack((points[:-1], points[1:]), axis=1), cmap="viridis", linewidths=3)
    pieces.set_array(3.6 * rows[::10, 4][:-1])
    axes.add_collection(pieces)
    figure.colorbar(pieces, ax=axes, label="speed (km/h)", shrink=0.8)
    low, high = points.min(axis=0) - NEAR_M, points.max(axis=0) + NEAR_M
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]))
    corners = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]) * (0.5 * body.length_m, 0.5 * body.width_m)
    corners[:, 0] += 0.5 * body.length_m - body.rear_overhang_m
    for at_s in np.arange(0.0, float(rows[-1, 0]), OUTLINE_EVERY_S):
        _, x, y, yaw = rows[int(np.searchsorted(rows[:, 0], at_s)), :4]
        turn = np.array([[np.cos(yaw), np.sin(yaw)], [-np.sin(yaw), np.cos(yaw)]])
        axes.add_patch(Polygon(corners @ turn + (x, y), fill=False, edgecolor=_INK, linewidth=0.8))


def _table(path: Path, columns: int) -> Array:
    """Raises SystemExit for a file that is not a trace."""
    try:
        table: Array = np.loadtxt(path, delimiter=",", skiprows=1, ndmin=2)
    except (OSError, ValueError) as error:
        raise SystemExit(f"{path}: {error}; give a trace, with its .agents.csv beside it") from error
    if not len(table) or table.shape[1] != columns:
        raise SystemExit(f"{path}: not a trace of {columns} columns with rows")
    return table


if __name__ == "__main__":
    main()
