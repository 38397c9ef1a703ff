import numpy as np
import pytest

from contract.geometry import Pose2
from simulator.chargers import CHARGER_W, REACH_M
from simulator.control import ByWireFault, DriverActs, GnssOutage, PersonPlaced, SeatPressed, StopButton
from simulator.scenario import Scenario, ScenarioEvent
from simulator.start_places import start_poses
from simulator.traffic.population import TrafficParams
from simulator.vehicle.plant import ENERGY, SPEED, PlantParams
from simulator.world import SimWorld, WorldError, WorldOptions
from tests.simulator.street import QuietPhone, a_world, street
from tests.simulator.traffic.careful_driver import START_NS, CarefulDriver
from vehicle_agent.config import Profile
from vehicle_agent.signals import DoorState, GnssFix, HmiOutput, ImuSample, SeatButton, SeatSensor

S = 1_000_000_000
QUIET = WorldOptions(traffic=None, lidar=False)


def test_a_seed_repeats_everything_a_vehicle_hears_and_another_seed_does_not() -> None:
    digests = []
    for seed in (3, 3, 4):
        driver = CarefulDriver(a_world(WorldOptions(), seed=seed))
        driver.drive(12.0)
        digests.append(driver.digest.hexdigest())
    assert digests[0] == digests[1] != digests[2]


def test_a_tick_hears_position_motion_doors_and_seats() -> None:
    world = a_world(QUIET)
    kinds = {type(item) for item in world.sensor_items("s1", START_NS)}
    assert kinds == {GnssFix, ImuSample, DoorState, SeatSensor}


def test_scans_come_ten_times_a_second_and_vehicles_take_turns() -> None:
    poses = {"s1": Pose2(20.0, 0.0, 0.0), "s2": Pose2(60.0, 0.0, 0.0)}
    profiles = dict.fromkeys(poses, Profile())
    world = SimWorld(street(), profiles, poses, 1, QuietPhone(), WorldOptions(traffic=None))
    due: dict[str, list[int]] = {"s1": [], "s2": []}
    for k in range(50):
        for vehicle_id, steps in due.items():
            if world.scan(vehicle_id, START_NS + k * 20_000_000) is not None:
                steps.append(k)
    assert due["s1"] == list(range(0, 50, 5))
    assert due["s2"] == list(range(1, 50, 5))


def test_another_shuttle_is_in_the_scan_and_its_own_is_not_doubled() -> None:
    poses = {"s1": Pose2(20.0, 0.0, 0.0), "s2": Pose2(32.0, 0.0, 0.0)}
    world = SimWorld(
        street(), dict.fromkeys(poses, Profile()), poses, 1, QuietPhone(), WorldOptions(traffic=None)
    )
    scan = world.scan("s1", START_NS)
    assert scan is not None
    points, intensities = scan
    bumper = points[(intensities == 60.0) & (points[:, 0] > 4.0)]
    assert bumper[:, 0].min() == pytest.approx(12.0 - 0.85, abs=0.1)


def test_doors_open_when_the_vehicle_says_so() -> None:
    world = a_world(QUIET)
    world.show("s1", HmiOutput("Welcome", "欢迎", "Doors open", "", True), START_NS)
    for k in range(120):
        items = world.sensor_items("s1", START_NS + k * 20_000_000)
    assert world.doors["s1"].is_open
    assert world.displays["s1"].announcements[0][1] == "Doors open"
    assert items


def test_a_vehicle_set_down_elsewhere_stands_there() -> None:
    driver = CarefulDriver(a_world(QUIET))
    driver.drive(8.0)
    driver.world.place("s1", Pose2(300.0, 0.0, 0.0))
    truth = driver.world.truth("s1")
    assert (truth.pose_map, truth.speed_mps) == (Pose2(300.0, 0.0, 0.0), 0.0)


def test_people_and_score_take_the_route_they_are_told() -> None:
    world = a_world(QUIET)
    bend = np.array([[20.0, 0.0], [25.0, 0.0], [25.0, 60.0]])
    world.follow("s1", bend)
    world.step(START_NS)
    assert world._ahead[0, 40] == pytest.approx([25.0, 15.0], abs=0.1)
    with pytest.raises(ValueError, match="two points"):
        world.follow("s1", np.zeros((1, 2)))


def test_a_scenario_makes_things_happen_at_their_time() -> None:
    driver = CarefulDriver(a_world(WorldOptions(traffic=TrafficParams(), lidar=False)))
    world = driver.world
    scenario = Scenario(
        (
            ScenarioEvent(START_NS + 2 * S, StopButton("s1", True)),
            ScenarioEvent(START_NS + S, GnssOutage("s1", True)),
            ScenarioEvent(START_NS + S, SeatPressed("s1", 2)),
            ScenarioEvent(START_NS + 3 * S, DriverActs("s1", brake_ratio=0.4)),
            ScenarioEvent(START_NS + 3 * S, ByWireFault("s1", True)),
            ScenarioEvent(START_NS + 3 * S, PersonPlaced(100.0, 4.0)),
        )
    )
    scenario.step(world, START_NS)
    assert not world.gnss["s1"].silent
    scenario.step(world, START_NS + S)
    items = world.sensor_items("s1", START_NS + S)
    assert not any(isinstance(item, GnssFix) for item in items)
    assert any(isinstance(item, SeatButton) for item in items)
    assert not world.module("s1").stop_pressed
    scenario.step(world, START_NS + 5 * S)
    assert world.module("s1").stop_pressed
    assert world.module("s1").faulted
    assert world.module("s1").driver.takes_over
    assert [100.0, 4.0] in world.people_near("s1", 200.0).tolist()
    assert scenario.is_over


def test_an_internal_fault_of_by_wire_takes_the_vehicle_and_gives_it_back_after_a_clear() -> None:
    driver = CarefulDriver(a_world(QUIET))
    driver.drive(5.0)
    module = driver.world.module("s1")
    module.injected_fault = True
    driver.drive(0.5)
    assert not module.enabled
    module.injected_fault = False
    driver.drive(1.5)
    assert module.enabled


def test_a_person_cannot_be_placed_in_a_world_without_people() -> None:
    with pytest.raises(WorldError, match="TrafficParams"):
        Scenario((ScenarioEvent(0, PersonPlaced(0.0, 0.0)),)).step(a_world(QUIET), 0)


def test_a_world_says_what_it_lacks() -> None:
    with pytest.raises(WorldError, match="at least one vehicle"):
        SimWorld(street(), {}, {}, 1, QuietPhone(), QUIET)
    with pytest.raises(WorldError, match="s1"):
        SimWorld(street(), {"s1": Profile()}, {}, 1, QuietPhone(), QUIET)


def test_vehicles_start_at_resting_places_and_too_many_are_refused() -> None:
    poses = start_poses(street(), ("s1", "s2"))
    assert [pose.x_m for pose in poses.values()] == pytest.approx([10.0, 590.0])
    with pytest.raises(WorldError, match="2 resting places"):
        start_poses(street(), ("s1", "s2", "s3"))


def test_a_shuttle_that_stands_where_shuttles_charge_is_charged_and_one_that_drives_by_is_not() -> None:
    world = a_world(QUIET)
    plant = world.fleet.plant
    s_m = street().charging_places[0].s_m
    charger, elsewhere = Pose2(s_m, 0.0, 0.0), Pose2(s_m + REACH_M + 1.0, 0.0, 0.0)
    params = PlantParams()
    for pose, gained_w in ((charger, CHARGER_W - params.idle_power_w), (elsewhere, -params.idle_power_w)):
        world.place("s1", pose)
        plant.state[0, ENERGY] = 0.5 * params.battery_j
        world.step(START_NS)
        before_j = float(plant.state[0, ENERGY])
        for k in range(1, 251):
            world.step(START_NS + k * 20_000_000)
        assert plant.state[0, ENERGY] - before_j == pytest.approx(5.0 * gained_w, rel=1e-6)
    world.place("s1", charger)
    plant.state[0, ENERGY] = params.battery_j
    plant.state[0, SPEED] = 2.0
    world.step(START_NS)
    assert plant.charging_w[0] == 0.0


def test_a_full_battery_takes_no_more() -> None:
    world = a_world(QUIET)
    plant = world.fleet.plant
    plant.charging_w[:] = CHARGER_W
    plant.step(0.1)
    assert world.fleet.plant.view(0).battery_ratio == 1.0
