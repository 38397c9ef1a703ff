"""The distributions of encounters, recorded and simulated, as an image."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from benchmarks.people.distributions import Encounters

_MEASURES = (
    ("decels_mps2", "hardest deceleration (m/s²)", (0.0, 4.0)),
    ("onsets_s", "vehicle's time away at slowing down (s)", (0.0, 4.0)),
    ("gaps_m", "least clearance (m)", (-0.5, 4.0)),
)


def plot_distributions(path: Path, parts: Mapping[str, tuple[Encounters, Encounters]]) -> None:
    """One row for each part: cumulative shares of recorded people (grey) and people of the model (blue)."""
    figure = Figure(figsize=(10.0, 2.9 * len(parts)), layout="constrained")
    axes = figure.subplots(len(parts), len(_MEASURES), squeeze=False)
    for row, (name, (recorded, aware)) in zip(axes, parts.items(), strict=True):
        for axis, (measure, label, limits) in zip(row, _MEASURES, strict=True):
            for found, colour, legend in (
                (recorded, "0.45", "recorded"),
                (aware, "C0", "model, car shifted"),
            ):
                values = np.sort(getattr(found, measure))
                shares = np.arange(1, len(values) + 1) / max(1, len(values))
                axis.step(values, shares, where="post", color=colour, label=f"{legend} ({len(values)})")
            axis.set(xlim=limits, ylim=(0.0, 1.0), xlabel=label)
            axis.grid(visible=True, alpha=0.3)
            axis.legend(fontsize="small")
        row[0].set_ylabel(f"{name.replace('_', ' ')}: share of people")
    figure.savefig(path, dpi=80)
