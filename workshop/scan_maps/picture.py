"""The picture an operator decides by: both maps from above, what changed in colours, changed tiles framed."""

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from contract.geometry import Array
from contract.point_map.tiles import Surfels
from workshop.scan_maps.comparison import ADDED, GONE, MOVED, NEW, SAME, UNSEEN, Changes, TileChange

# Told apart by people who do not see red or green (Okabe and Ito 2008).
_COLOURS = {
    UNSEEN: ("not seen", "#d9d9d9"),
    SAME: ("same", "#7f7f7f"),
    ADDED: ("added", "#56b4e9"),
    NEW: ("new", "#0072b2"),
    MOVED: ("moved", "#e69f00"),
    GONE: ("gone", "#d55e00"),
}


def write_picture(
    path: Path, new: Surfels, old: Surfels, changes: Changes, tiles: Sequence[TileChange], tile_m: float,
    poses: Array,
) -> None:  # fmt: skip
    """A PNG. poses (k, 4, 4): the way of the scans, which is drawn too."""
    # matplotlib takes a second to import.
    from matplotlib.figure import Figure
    from matplotlib.patches import Rectangle

    low, high = new.means[:, :2].min(axis=0) - 5.0, new.means[:, :2].max(axis=0) + 5.0
    span = float((high - low).max())
    figure = Figure(figsize=(9.0, max(4.0, 9.0 * float(high[1] - low[1]) / span)), dpi=120)
    axes = figure.add_subplot()
    size = min(6.0, max(0.3, (300.0 / span) ** 2))
    for kind, (name, colour) in _COLOURS.items():
        points = np.concatenate((new.means[changes.new == kind], old.means[changes.old == kind]))
        if len(points):
            axes.scatter(points[:, 0], points[:, 1], s=size, c=colour, label=name, linewidths=0)
    axes.plot(poses[:, 0, 3], poses[:, 1, 3], color="black", linewidth=0.6)
    for tile in tiles:
        if tile.is_changed:
            corner = (tile.ix * tile_m, tile.iy * tile_m)
            axes.add_patch(Rectangle(corner, tile_m, tile_m, fill=False, edgecolor="#d55e00", linewidth=1.2))
            axes.text(
                corner[0] + 0.5, corner[1] + 0.5, f"{math.floor(100 * tile.changed_ratio)} %", fontsize=7
            )
    axes.set_xlim(low[0], high[0])
    axes.set_ylim(low[1], high[1])
    axes.set_aspect("equal")
    axes.set_xlabel("x (m)")
    axes.set_ylabel("y (m)")
    axes.legend(loc="upper right", fontsize=7, markerscale=4.0)
    figure.tight_layout()
    figure.savefig(path, metadata={"Software": None})
