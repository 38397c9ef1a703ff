"""Every vehicle's body, by-wire module and bus, stepped together."""

from contract.geometry import Pose2
from simulator.bus import ListBus
from simulator.ecus.by_wire import ByWire
from simulator.ecus.module import Module
from simulator.ecus.servo_cart import ServoModule
from simulator.vehicle.plant import (
    Plant,
    PlantParams,
    PlantView,
    plant_params,
)
from vehicle_agent.config import Profile
from vehicle_agent.signals import CanFrame

STEP_NS = 20_000_000


def module_of(profile: Profile) -> Module:
    """The by-wire module that the vehicle has."""
    return ServoModule(profile) if profile.by_wire.kind == "servo" else ByWire(profile)


class SimFleet:
    """Vehicles by id, in the order given. World time is the end of the last step."""

    def __init__(
        self,
        profiles: dict[str, Profile],
        poses_map: dict[str, Pose2],
        params: dict[str, PlantParams] | None = None,
    ) -> None:
        """KeyError for a vehicle without a start pose; `params` overrides the dynamics of some."""
        self.vehicle_ids = tuple(profiles)
        self.profiles = profiles
        chosen = params or {}
        self.plant = Plant(
            tuple(chosen.get(v) or plant_params(profile) for v, profile in profiles.items()),
            tuple(poses_map[v] for v in profiles),
        )
        self.modules = {v: module_of(profile) for v, profile in profiles.items()}
        self.buses = {v: ListBus() for v in profiles}
        self._number = {v: i for i, v in enumerate(profiles)}
        self._views = {v: self.plant.view(i) for v, i in self._number.items()}

    def truth(self, vehicle_id: str) -> PlantView:
        """The vehicle's true motion at the end of the last step."""
        return self._views[vehicle_id]

    def frames_from_vehicle(self, vehicle_id: str, frames: tuple[CanFrame, ...]) -> None:
        self.buses[vehicle_id].send_from_vehicle(frames)

    def frames_to_vehicle(self, vehicle_id: str) -> tuple[CanFrame, ...]:
        """The module's reports since the last call."""
        return self.buses[vehicle_id].take_for_vehicle()

    def step(self, now_ns: int) -> None:
        """Advance from now_ns to now_ns + 20 ms; frames stamped in that time are received at its end."""
        end_ns = now_ns + STEP_NS
        for vehicle_id, i in self._number.items():
            module, truth = self.modules[vehicle_id], self._views[vehicle_id]
            for frame in self.buses[vehicle_id].take_for_module(end_ns):
                module.receive(frame)
            module.supervise(end_ns, truth)
            self.plant.commands[i, :] = module.targets(truth).row()
        self.plant.step(STEP_NS * 1e-9)
        for vehicle_id, i in self._number.items():
            truth = self._views[vehicle_id] = self.plant.view(i)
            self.buses[vehicle_id].send_from_module(self.modules[vehicle_id].report(end_ns, truth))

    def place(self, vehicle_id: str, pose_map: Pose2, speed_mps: float = 0.0) -> None:
        """Place a vehicle, at rest or with a speed."""
        i = self._number[vehicle_id]
        self.plant.place(i, pose_map, speed_mps)
        self._views[vehicle_id] = self.plant.view(i)
