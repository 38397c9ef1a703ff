"""The tick's part of a change of the map: builds the rooms beside the loop, and changes over in one tick.

The vehicle stands then, so that a thread beside the loop and a file that is renamed cost nothing but a few
milliseconds. The state of everything that knows no map goes on: bus, position, faults, doors and riders.
"""

import threading
from collections.abc import Callable
from dataclasses import dataclass

import msgspec
import structlog

from contract.roads.load import MapError
from contract.roads.model import RoadMap
from contract.wire.maps import MapFailure
from vehicle_agent.config import ProfileError
from vehicle_agent.mission.map_change import OffTheLanes, mission_on
from vehicle_agent.onboard.car import Car
from vehicle_agent.onboard.state import OnboardState
from vehicle_agent.runtime.computer import VehicleComputer
from vehicle_agent.runtime.processes.agent_files import AgentFolder
from vehicle_agent.runtime.processes.mailbox import MapAnswer
from vehicle_agent.runtime.recording.recorder import Recorder
from vehicle_agent.signals import Outputs

log = structlog.get_logger()

BuildCar = Callable[[RoadMap], Car]
BeginRun = Callable[[RoadMap], Recorder | None]


@dataclass(frozen=True, slots=True)
class _Built:
    """car  None if the map cannot be driven by: then why"""

    road_map: RoadMap | None
    car: Car | None
    detail: str = ""


class MapSwitch:
    """`offer` takes the link's offers; `poll` follows each tick."""

    def __init__(self, files: AgentFolder, build_car: BuildCar, begin_run: BeginRun) -> None:
        """begin_run: the recorder of the run that begins with this map."""
        self._files = files
        self._build_car = build_car
        self._begin_run = begin_run
        self._version = ""
        self._built: _Built | None = None
        self._builder: threading.Thread | None = None

    def offer(self, map_version: str) -> None:
        """A repeat is ignored."""
        if map_version == self._version:
            return
        self._version, self._built = map_version, None
        self._builder = None
        if map_version:
            self._builder = threading.Thread(target=self._build, args=(map_version,), daemon=True)
            self._builder.start()

    def poll(self, computer: VehicleComputer, outputs: Outputs) -> MapAnswer | None:
        """Changes over if the new rooms are there and the moment is safe; what there is to tell the link."""
        built, version = self._built, self._version
        if built is None or not version:
            return None
        if built.car is None or built.road_map is None:
            return self._refused("unsound", built.detail)
        ego, state = outputs.flow.ego, computer.state
        if not ego.valid:
            return None
        before, after = computer.car.mission, built.car.mission
        mission = mission_on(state.mission, before.network, after.network, ego.pose_map)
        if isinstance(mission, OffTheLanes):
            return self._refused("off_the_lanes", mission.detail)
        if mission is None:
            return None
        try:
            self._files.adopt_next_map(version)
        except OSError as error:
            return self._refused("not_stored", str(error))
        is_same_frame = before.network.road_map.origin == after.network.road_map.origin
        moved = state_on(built.car, state, is_same_frame=is_same_frame)
        moved = msgspec.structs.replace(moved, mission=mission)
        computer.change_over(built.car, moved, self._begin_run(built.road_map))
        log.info("map.changed", map_version=version)
        self._version, self._built = "", None
        return MapAnswer(version)

    def _refused(self, code: MapFailure, detail: str) -> MapAnswer:
        version, self._version, self._built = self._version, "", None
        return MapAnswer(version, code, detail)

    def _build(self, map_version: str) -> None:
        """In a thread of its own: all it shares with the tick is the assignment at its end."""
        try:
            road_map = self._files.next_map(map_version)
            built = _Built(road_map, self._build_car(road_map))
        except (MapError, ProfileError) as error:
            built = _Built(None, None, str(error))
        if self._builder is threading.current_thread():
            self._built = built


def state_on(car: Car, state: OnboardState, *, is_same_frame: bool) -> OnboardState:
    """The state with the rooms that read the map begun anew: what they remember names its lanes and areas.

    is_same_frame: both maps have one origin; otherwise the position is found anew, too
    """
    return msgspec.structs.replace(
        state,
        localization=state.localization if is_same_frame else car.localization.initial(),
        world=car.world.initial(),
        planning=car.planning.initial(),
        hmi=car.hmi.initial(),
    )
