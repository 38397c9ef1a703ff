"""Vehicles of the simulated service on real connections, with their disks in a folder."""

import random
from pathlib import Path

from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey

from benchmarks.fleet_soak.real_link import RealNetwork
from benchmarks.fleet_soak.real_schedule import RealSchedule
from campusloop.simulation.fleet.body import Body
from campusloop.simulation.fleet.surroundings import Cabin, Observer, VehicleSetup
from campusloop.simulation.fleet.vehicle import SimulatedVehicle
from contract.geometry import Pose2
from contract.roads.model import RoadMap
from contract.roads.network import RoadNetwork
from vehicle_agent.config import Profile
from vehicle_agent.link.keys import public_key_text, signature_text
from vehicle_agent.mission.mission import Mission
from vehicle_agent.stacks.rooms import mission_rules

SEATS = 6


class SoakFleet:
    """public_keys: by vehicle. cuts, crashes: what `disturb` has done so far."""

    def __init__(
        self,
        road_map: RoadMap,
        count: int,
        folder: Path,
        schedule: RealSchedule,
        network: RealNetwork,
        cabin: Cabin,
        observer: Observer,
    ) -> None:
        roads = RoadNetwork(road_map)
        mission = Mission(roads, mission_rules(Profile()))
        self.vehicles: dict[str, SimulatedVehicle] = {}
        self.public_keys: dict[str, str] = {}
        self.cuts = self.crashes = 0
        self._network = network
        for number, place in enumerate(road_map.resting_places[:count], start=1):
            vehicle_id = f"shuttle-{number:02d}"
            key = Ed25519PrivateKey.generate()
            self.public_keys[vehicle_id] = public_key_text(key)
            (folder / vehicle_id).mkdir(parents=True)
            setup = VehicleSetup(
                vehicle_id,
                folder / vehicle_id,
                mission,
                SEATS,
                0,
                lambda text, key=key: signature_text(key, text),  # type: ignore[misc]
                syncs_disk=True,
            )
            body = Body(Pose2(*roads.pose(place.lane_id, place.s_m)))
            self.vehicles[vehicle_id] = SimulatedVehicle(setup, body, schedule, network, cabin, observer)

    def disturb(self, rng: random.Random) -> str:
        """A cut connection or a computer that loses its power; what was done, and to which vehicle."""
        vehicle_id = rng.choice(sorted(self.vehicles))
        if rng.random() < 0.5:
            self.crashes += 1
            self.vehicles[vehicle_id].crash()
            return f"{vehicle_id} loses its power"
        self.cuts += self._network.cut(vehicle_id)
        return f"{vehicle_id}'s connection is cut"

    @property
    def driven_m(self) -> float:
        return sum(vehicle.body.driven_m for vehicle in self.vehicles.values())

    def held(self) -> tuple[str, ...]:
        return tuple(name for name, v in self.vehicles.items() if v.is_held and v.is_running)

    def oldest_events(self) -> dict[str, tuple[str, int]]:
        events = {name: vehicle.oldest_event for name, vehicle in self.vehicles.items()}
        return {name: event for name, event in events.items() if event is not None}

    def sections_left(self) -> dict[str, frozenset[tuple[str, int]]]:
        memories = {name: vehicle.memory for name, vehicle in self.vehicles.items()}
        return {
            name: frozenset((grant.section_id, grant.fence) for grant in memory.released)
            for name, memory in memories.items()
            if memory is not None
        }
