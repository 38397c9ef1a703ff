"""A camera at a crossing, through the cloud to the cart that stands near it, in virtual time."""

from pathlib import Path

import msgspec

from campusloop.virtual.campus import CampusOptions, VirtualCampus
from contract.roads.load import load_map, with_version
from contract.roads.model import ObservationArea, RoadMap
from contract.roads.network import RoadNetwork
from simulator.infrastructure import CameraParams
from tests.server.feeds.roads.shipped import CAMPUS_MAP
from vehicle_agent.config import load_profile

PROFILES = Path(__file__).resolve().parents[2] / "vehicle_agent" / "profiles"
CAMERAS = CameraParams(miss=0.0, ghost=0.0, dropout=0.0)


def with_crossings_at_resting_places() -> RoadMap:
    """One beside each resting place: wherever a cart starts, a camera is near it."""
    road_map = load_map(CAMPUS_MAP)
    network = RoadNetwork(road_map)
    areas = []
    for place in road_map.resting_places:
        x_m, y_m, _ = network.pose(place.lane_id, place.s_m)
        corners = tuple((x_m + a, y_m + b) for a, b in ((-6.0, -6.0), (6.0, -6.0), (6.0, 6.0), (-6.0, 6.0)))
        stop = (place.lane_id, max(0.0, place.s_m - 7.0))
        areas.append(ObservationArea(f"at-{place.place_id}", "crossing", corners, (stop,)))
    return with_version(msgspec.structs.replace(road_map, observation_areas=tuple(areas)))


def heard(campus: VirtualCampus) -> dict[str, int]:
    (vehicle,) = campus.vehicles.values()
    assert vehicle.wired.computer is not None
    return {word.area_id: word.stamp_ns for word in vehicle.wired.computer.state.world.presence}


def test_the_cart_hears_the_camera_near_it_and_forgets_it_when_it_falls_silent(tmp_path: Path) -> None:
    options = CampusOptions(
        with_crossings_at_resting_places(),
        tmp_path,
        seed=1,
        vehicles=1,
        profile=load_profile(PROFILES / "nus-cart.toml"),
        traffic=None,
        cameras=CAMERAS,
    )
    campus = VirtualCampus(options)
    campus.start()
    campus.conductor.run_for(5.0)
    words = heard(campus)
    assert len(words) >= 1
    assert len(words) < len(options.road_map.observation_areas)
    ages_s = [(campus.conductor.now_ns - stamp_ns) * 1e-9 for stamp_ns in words.values()]
    assert min(ages_s) > 0.1
    assert max(ages_s) < 1.0
    campus.conductor.remove("cameras")
    campus.conductor.run_for(5.0)
    assert heard(campus) == {}
    campus.stop()
