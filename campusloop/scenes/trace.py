"""The ground truth of a driven scene, as arrays and as files for scoring."""

import csv
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from contract.geometry import Array
from simulator.traffic.actors import Bodies
from simulator.vehicle.plant import PlantView

VEHICLE_COLUMNS = ("t_s", "x_m", "y_m", "yaw_rad", "v_mps", "a_mps2", "steer_rad")
AGENT_COLUMNS = ("t_s", "id", "kind", "x_m", "y_m", "yaw_rad", "length_m", "width_m")


@dataclass(slots=True)
class SceneTrace:
    """rows: VEHICLE_COLUMNS every 20 ms, rear-axle centre; agents: the bodies around at those times."""

    rows: list[tuple[float, ...]] = field(default_factory=list)
    agents: list[Bodies] = field(default_factory=list)

    def add(self, t_s: float, truth: PlantView, bodies: Bodies) -> None:
        pose = truth.pose_map
        self.rows.append(
            (t_s, pose.x_m, pose.y_m, pose.yaw_rad, truth.speed_mps, truth.accel_mps2, truth.steer_rad)
        )
        self.agents.append(bodies)

    def array(self) -> Array:
        """(n, 7) see VEHICLE_COLUMNS."""
        table: Array = np.array(self.rows).reshape(-1, len(VEHICLE_COLUMNS))
        return table

    def write(self, folder: Path, name: str) -> None:
        """NAME.csv and NAME.agents.csv."""
        folder.mkdir(parents=True, exist_ok=True)
        with (folder / f"{name}.csv").open("w", newline="", encoding="utf-8") as file:
            rows = csv.writer(file)
            rows.writerow(VEHICLE_COLUMNS)
            rows.writerows([f"{value:.5f}" for value in row] for row in self.rows)
        with (folder / f"{name}.agents.csv").open("w", newline="", encoding="utf-8") as file:
            rows = csv.writer(file)
            rows.writerow(AGENT_COLUMNS)
            for row, bodies in zip(self.rows, self.agents, strict=True):
                for k in range(len(bodies.numbers)):
                    pose, size = bodies.poses_map[k], bodies.sizes_m[k]
                    values = [f"{value:.4f}" for value in (*pose, *size)]
                    rows.writerow([f"{row[0]:.2f}", int(bodies.numbers[k]), int(bodies.kinds[k]), *values])
