"""The tick's part of a change of the localization map: it changes over while the vehicle stands.

No room changes: the worker beside the tick reads another folder, in the same frame. A run compares its scans
with one map, so another run begins.
"""

import threading
from collections.abc import Callable
from dataclasses import dataclass

import structlog

from contract.localization_maps import LocalizationMapError
from contract.occupancy.tile_files import OccupancyTilesIndex
from contract.point_map.map_files import PointMapIndex
from contract.roads.model import RoadMap
from contract.runlog.records import NO_LOCALIZATION_MAP
from contract.wire.localization_maps import LocalizationMapFailure
from vehicle_agent.localization.scan_map.stored_map import is_of_place
from vehicle_agent.runtime.computer import VehicleComputer
from vehicle_agent.runtime.processes.agent_files import AgentFolder
from vehicle_agent.runtime.processes.mailbox import LocalizationMapAnswer
from vehicle_agent.runtime.recording.recorder import Recorder

log = structlog.get_logger()

Index = PointMapIndex | OccupancyTilesIndex
BeginRun = Callable[[RoadMap], Recorder | None]


@dataclass(frozen=True, slots=True)
class _Read:
    """index  None if it cannot be read: then why"""

    index: Index | None
    detail: str = ""


class LocalizationSwitch:
    """Of a vehicle that compares scans. `offer` takes the link's offers; `poll` follows each tick."""

    def __init__(self, files: AgentFolder, index: Index | None) -> None:
        """index: of the checked map in force; None for a vehicle that waits for its first one."""
        self._files = files
        self._index = index
        self._version = ""
        self._read: _Read | None = None
        self._reader: threading.Thread | None = None
        self._begin_run: BeginRun = lambda _road_map: None

    def on_change(self, begin_run: BeginRun) -> None:
        """begin_run: the recorder of the run that begins with another map."""
        self._begin_run = begin_run

    def version_on(self, road_map: RoadMap) -> str:
        """The version that scans are compared with, if it lies in the road map's frame."""
        index = self._index
        if index is None or not is_of_place(index, road_map.origin):
            return NO_LOCALIZATION_MAP
        return index.map_version

    def offer(self, map_version: str) -> None:
        """A repeat is ignored."""
        if map_version == self._version:
            return
        self._version, self._read, self._reader = map_version, None, None
        if map_version:
            self._reader = threading.Thread(target=self._read_index, args=(map_version,), daemon=True)
            self._reader.start()

    def poll(self, computer: VehicleComputer) -> LocalizationMapAnswer | None:
        """Changes over if the vehicle stands; what there is to tell the link and the worker."""
        read, version = self._read, self._version
        if read is None or not version:
            return None
        if read.index is None:
            return self._refused("unsound", read.detail)
        road_map = computer.car.mission.network.road_map
        if not is_of_place(read.index, road_map.origin):
            return self._refused("elsewhere", f"it lies in another frame than {road_map.map_version}")
        if not computer.state.mission.standing_since_ns:
            return None
        try:
            self._files.localization.adopt(version)
        except OSError as error:
            return self._refused("not_stored", str(error))
        self._index = read.index
        self._version, self._read = "", None
        computer.begin_run(self._begin_run(road_map))
        log.info("localization_map.changed", map_version=version)
        return LocalizationMapAnswer(version)

    def _refused(self, code: LocalizationMapFailure, detail: str) -> LocalizationMapAnswer:
        version, self._version, self._read = self._version, "", None
        return LocalizationMapAnswer(version, code, detail)

    def _read_index(self, map_version: str) -> None:
        """In a thread of its own: all it shares with the tick is the assignment at its end."""
        try:
            read = _Read(self._files.localization_index(self._files.localization.root / map_version))
        except LocalizationMapError as error:
            read = _Read(None, str(error))
        if self._reader is threading.current_thread():
            self._read = read
