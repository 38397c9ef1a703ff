"""One turn of a vehicle's lidars as a picture: from above, from the side and ahead."""

from pathlib import Path

import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt

# Retro-reflectors are brighter; they all have the last colour.
_BRIGHT = 110.0


def draw_scan(path: Path, points_base: np.ndarray, intensities: np.ndarray, title: str) -> None:
    """points_base (n, 3), intensities (n,); the colour is the intensity."""
    figure = plt.figure(figsize=(15.0, 12.0))
    colours = np.minimum(intensities, _BRIGHT)
    x, y, z = points_base.T
    ahead = (x > 4.0) & (x < 30.0)
    views = (
        ((0.05, 0.44, 0.87, 0.52), x, y, (-45.0, 65.0), (-30.0, 30.0), "from above: x ahead, y left (m)"),
        ((0.05, 0.23, 0.87, 0.17), x, z, (-45.0, 65.0), (-1.5, 14.0), "from the right: x ahead, z up (m)"),
        ((0.05, 0.03, 0.87, 0.16), -y[ahead], z[ahead], (-30.0, 30.0), (-1.5, 12.0),
         "4 m to 30 m ahead, as the vehicle looks: right, up (m)"),
    )  # fmt: skip
    for place, across, up, width, height, name in views:
        axes = figure.add_axes(place)
        shades = colours[ahead] if len(across) != len(colours) else colours
        drawn = axes.scatter(
            across, up, c=shades, s=0.7, cmap="turbo", vmin=0.0, vmax=_BRIGHT, linewidths=0.0
        )
        axes.set_xlim(*width)
        axes.set_ylim(*height)
        axes.set_aspect("equal")
        axes.set_title(name, fontsize=10, loc="left")
    figure.colorbar(drawn, cax=figure.add_axes((0.94, 0.1, 0.012, 0.8)), label="intensity")
    figure.suptitle(title)
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=75)
    plt.close(figure)
