"""Hours of fault-free driving in virtual time, and the stops by guard or gate without a reason."""

import tempfile
import time
from pathlib import Path

from benchmarks.reporting.report import Row
from campusloop.virtual.conductor import STEP_NS
from campusloop.virtual.solo_drive import VEHICLE_ID, SoloDrive
from contract.roads.load import load_map
from contract.roads.model import RoadMap
from contract.wire.messages import Command
from simulator.traffic.population import TrafficParams
from vehicle_agent.config import Profile

SHIPPED = Path(__file__).resolve().parents[2] / "maps" / "shanghai-university" / "map.json"
DRIVE_S = 900.0
# A stop with no person nearer than this is without a reason.
REASON_M = 5.0
_STANDS_MPS = 0.05


def fault_free_hours(profile: Profile, hours: float, seed: int) -> list[Row]:
    """A row for each drive of at most a quarter of an hour; every drive has people and stops of its own."""
    road_map = load_map(SHIPPED)
    rows: list[Row] = []
    left_s = 3600.0 * hours
    while left_s > 0.0:
        row = _drive(road_map, profile, min(DRIVE_S, left_s), seed + len(rows))
        rows.append(row)
        left_s -= DRIVE_S
        print(row, flush=True)
    return rows


class StopCounter:
    """Counts the reactions of guard and gate, each episode once."""

    def __init__(self, drive: SoloDrive) -> None:
        self._drive = drive
        self.nuisance: list[str] = []
        self.avoided = 0
        self._avoiding = self._stood = False
        self._stopped = ""

    def step(self) -> None:
        vehicle = self._drive.vehicle
        assert vehicle.wired.computer is not None
        guard = vehicle.wired.computer.state.guard
        stopped = vehicle.wired.gate.braking or (
            guard.reason if guard.mode in ("minimal_risk", "fault") else ""
        )
        if stopped and not self._stopped:
            self.nuisance.append(stopped)
            self._drive.vehicle.put_link_message(self._drive.now_ns, self._resume())
        self._stopped = stopped
        self._avoidance(guard.avoiding)

    def _avoidance(self, avoiding: bool) -> None:
        """A stop for a person is a nuisance stop if no person is near by ground truth."""
        self.avoided += avoiding and not self._avoiding
        stands = self._drive.world.truth(VEHICLE_ID).speed_mps < _STANDS_MPS
        if not avoiding:
            self._stood = False
        elif stands and not self._stood:
            self._stood = True
            reach_m = REASON_M + 4.0
            if len(self._drive.world.people_near(VEHICLE_ID, reach_m)) == 0:
                self.nuisance.append("nobody there")
        self._avoiding = avoiding

    def _resume(self) -> Command:
        number = len(self.nuisance) + 1
        return Command(number, f"again-{number}", "resume")


def _drive(road_map: RoadMap, profile: Profile, seconds: float, seed: int) -> Row:
    begun_s = time.process_time()
    with tempfile.TemporaryDirectory() as folder:
        drive = SoloDrive(
            road_map,
            Path(folder),
            seed,
            stops=len(road_map.stops),
            traffic=TrafficParams(),
            profile=profile,
        )
        drive.set_off()
        counter = StopCounter(drive)
        for _ in range(round(seconds * 1e9 / STEP_NS)):
            drive.step()
            counter.step()
        score = drive.world.score(VEHICLE_ID)
        drive.vehicle.shut_down()
    return {
        "part": "fault-free",
        "kind": f"seed {seed}",
        "hours": seconds / 3600.0,
        "distance_m": score.distance_m,
        "contacts": score.contacts_people + score.contacts_vehicles + score.contacts_buildings,
        "encounters": score.encounters,
        "guard_braked": counter.avoided,
        "nuisance_stops": len(counter.nuisance),
        "nuisance": "; ".join(counter.nuisance),
        "cpu_s": time.process_time() - begun_s,
    }
