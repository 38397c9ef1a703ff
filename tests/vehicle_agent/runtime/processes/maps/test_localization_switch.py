"""The tick's part of another localization map: only while the vehicle stands, and only in its frame."""

import time
from pathlib import Path

import msgspec
import pytest

from contract.roads.load import encode_map
from contract.roads.model import Origin, RoadMap
from contract.runlog.records import NO_LOCALIZATION_MAP
from tests.contract.localization_folders import occupancy_map, point_map
from tests.contract.roads.ring_map import ring_map
from tests.full_disk import full_disk
from vehicle_agent.config import Profile
from vehicle_agent.onboard.car import initial_state
from vehicle_agent.runtime.computer import VehicleComputer
from vehicle_agent.runtime.processes.agent_files import AgentFolder
from vehicle_agent.runtime.processes.mailbox import LocalizationMapAnswer
from vehicle_agent.runtime.processes.maps.localization_switch import LocalizationSwitch
from vehicle_agent.stacks.choice import build_car

ROADS = ring_map()
CAR = build_car(Profile(stack="snow_lion"), ROADS, NO_LOCALIZATION_MAP)


class Vehicle:
    """A computer that stands or drives as the test says, and its switch."""

    def __init__(self, folder: Path) -> None:
        self.files = AgentFolder(folder)
        (folder / "map.json").write_bytes(encode_map(ROADS))
        (folder / "profile.toml").write_text('stack = "snow_lion"\n')
        self.computer = VehicleComputer(CAR, initial_state(CAR))
        self.switch = LocalizationSwitch(self.files, None)
        self.switch.on_change(self.begin_run)
        self.runs: list[str] = []

    def begin_run(self, road_map: RoadMap) -> None:
        self.runs.append(self.switch.version_on(road_map))

    def stands(self, since_ns: int) -> None:
        state = self.computer.state
        mission = state.mission.after(standing_since_ns=since_ns)
        self.computer.state = msgspec.structs.replace(state, mission=mission)

    def polled(self, tries: int = 200) -> LocalizationMapAnswer | None:
        """Ticks until there is an answer; None if there is none by then."""
        for _ in range(tries):
            answer = self.switch.poll(self.computer)
            if answer is not None:
                return answer
            time.sleep(0.005)
        return None


@pytest.fixture
def vehicle(tmp_path: Path) -> Vehicle:
    (tmp_path / "vehicle").mkdir()
    return Vehicle(tmp_path / "vehicle")


def stored(vehicle: Vehicle, folder: str, origin: Origin = ROADS.origin) -> str:
    index = point_map(vehicle.files.localization.root / folder, origin)
    (vehicle.files.localization.root / folder).rename(vehicle.files.localization.root / index.map_version)
    return index.map_version


def test_it_changes_over_once_the_vehicle_stands_and_begins_a_run(vehicle: Vehicle) -> None:
    version = stored(vehicle, "map")
    assert vehicle.switch.version_on(ROADS) == NO_LOCALIZATION_MAP
    vehicle.switch.offer(version)
    vehicle.stands(0)
    assert vehicle.polled(tries=40) is None
    assert vehicle.files.localization.in_force() is None
    vehicle.stands(1)
    assert vehicle.polled() == LocalizationMapAnswer(version)
    assert vehicle.runs == [version]
    assert vehicle.files.localization.in_force() == vehicle.files.localization.root / version
    assert vehicle.polled(tries=3) is None


def test_a_withdrawn_offer_changes_nothing(vehicle: Vehicle) -> None:
    vehicle.stands(1)
    vehicle.switch.offer(stored(vehicle, "map"))
    vehicle.switch.offer("")
    assert vehicle.polled(tries=40) is None


def test_a_map_of_another_frame_of_another_kind_or_none_is_refused(vehicle: Vehicle) -> None:
    vehicle.stands(1)
    elsewhere = stored(vehicle, "map", Origin(ROADS.origin.latitude_deg, ROADS.origin.longitude_deg + 0.01))
    occupancy_map(vehicle.files.localization.root / "cells", ROADS.origin)
    for version, code in ((elsewhere, "elsewhere"), ("cells", "unsound"), ("nothing", "unsound")):
        vehicle.switch.offer(version)
        answer = vehicle.polled()
        assert answer is not None
        assert (answer.map_version, answer.refusal) == (version, code)
    assert vehicle.runs == []


def test_a_full_disk_leaves_the_map_in_force(vehicle: Vehicle) -> None:
    vehicle.stands(1)
    version = stored(vehicle, "map")
    vehicle.switch.offer(version)
    with full_disk():
        answer = vehicle.polled()
    assert answer is not None
    assert answer.refusal == "not_stored"
    assert (vehicle.files.localization.in_force(), vehicle.runs) == (None, [])
    vehicle.switch.offer(version)
    assert vehicle.polled() == LocalizationMapAnswer(version), "offered again, it is taken"
