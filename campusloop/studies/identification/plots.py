"""Plots of an identification: what was measured beside what the identified vehicle would have done."""

from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from vehicle_agent.brake_map import BrakeMap
from vehicle_agent.identification.identify import Identification

_MEASURED, _PREDICTED = "#15201b", "#cc3311"


def write_plots(found: Identification, folder: Path) -> list[Path]:
    """Writes pedals.png and steering.png."""
    folder.mkdir(parents=True, exist_ok=True)
    written = []
    for name, figure in (("pedals", _pedals(found)), ("steering", _steering(found))):
        FigureCanvasAgg(figure)
        path = folder / f"{name}.png"
        figure.savefig(path, dpi=110)
        written.append(path)
    return written


def _pedals(found: Identification) -> Figure:
    figure = Figure(figsize=(9.0, 7.0), layout="constrained")
    speeds, residuals, maps = figure.subplots(3, 1)
    pedals, response = found.pedals, found.profile.response
    speeds.plot(pedals.report_s, pedals.speed_mps, ".", color=_MEASURED, markersize=2, label="reported")
    speeds.plot(pedals.report_s, pedals.predicted_mps, ".", color=_PREDICTED, markersize=1, label="predicted")
    speeds.set(ylabel="speed (m/s)")
    speeds.legend(loc="upper right")
    off_mps = pedals.speed_mps - pedals.predicted_mps
    residuals.plot(pedals.report_s, off_mps, ".", color=_MEASURED, markersize=1)
    residuals.set(xlabel="time (s)", ylabel="reported - predicted (m/s)")
    decels = np.linspace(0.02, 4.0, 200)
    brakes = BrakeMap(response.brake_gain, response.brake_offset, response.brake_knee_mps2)
    maps.plot([brakes.brake_ratio(float(a)) for a in decels], decels, color=_PREDICTED, label="brake")
    accels = np.linspace(0.0, 1.2, 50)
    maps.plot(
        response.throttle_per_mps2 * accels, accels, color=_MEASURED, linestyle="--", label="throttle at rest"
    )
    maps.set(xlabel="pedal", ylabel="m/s2", xlim=(0.0, 1.0))
    maps.legend()
    return figure


def _steering(found: Identification) -> Figure:
    figure = Figure(figsize=(9.0, 5.0), layout="constrained")
    rates, residuals = figure.subplots(2, 1)
    steering = found.steering
    rates.plot(steering.tick_s, steering.yaw_rate_radps, color=_MEASURED, linewidth=0.5, label="gyroscope")
    rates.plot(steering.tick_s, steering.predicted_radps, color=_PREDICTED, linewidth=0.8, label="predicted")
    rates.set(ylabel="yaw rate (rad/s)")
    rates.legend(loc="upper right")
    off_radps = steering.yaw_rate_radps - steering.predicted_radps
    residuals.plot(steering.tick_s, off_radps, ".", color=_MEASURED, markersize=1)
    residuals.set(xlabel="time (s)", ylabel="measured - predicted (rad/s)")
    return figure
