"""Random missions of three shuttles on the shipped and on generated maps: `--missions 1000 --seed 1`.

Every mission goes from a resting place over a stop to another resting place, sections granted one by one in
a random order of turns. Exit 1 when shuttles ever get stuck or hold conflicting ground.
"""

import argparse
import random
import time
from pathlib import Path

from contract.roads.load import load_map
from contract.roads.model import RoadMap
from tests.contract.roads.driven_fleet import DrivenFleet
from tests.contract.roads.generated_maps import generated_map

ROOT = Path(__file__).resolve().parents[3]
GENERATED = tuple(range(1, 7))


def run(name: str, road_map: RoadMap, missions: int, seed: int) -> None:
    """Raises AssertionError, with who waits for whom, when the fleet is stuck."""
    rng = random.Random(seed)
    fleet = DrivenFleet(road_map, 3)
    begun, rounds = time.monotonic(), 0
    while sum(fleet.missions.values()) < missions:
        for vehicle_id in fleet.control.vehicle_ids:
            if fleet.is_idle(vehicle_id):
                assert fleet.send(vehicle_id, rng.randrange(1000), rng.randrange(1000)), "refused from rest"
        rounds += fleet.finish(rng)
    done = sum(fleet.missions.values())
    took_s = time.monotonic() - begun
    print(f"{name}: {done} missions, {rounds} rounds, 0 deadlocks, seed {seed}, {took_s:.1f} s")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--missions", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    shipped = [load_map(path) for path in sorted((ROOT / "maps").glob("*/map.json"))]
    for road_map in shipped:
        run(road_map.name, road_map, arguments.missions, arguments.seed)
    for number in GENERATED:
        run(f"generated campus {number}", generated_map(number), arguments.missions, arguments.seed)


if __name__ == "__main__":
    main()
