"""A room drives by the numbers that its page gives."""

from typing import Any

import pytest

from tests.documented import differing
from vehicle_agent.can import handshake, module_state
from vehicle_agent.can.pacmod import consistency, watchdog
from vehicle_agent.gate.settings import GateSettings
from vehicle_agent.guard.collision import Avoidance
from vehicle_agent.guard.guard import Guard
from vehicle_agent.guard.limits import Limits
from vehicle_agent.hmi.announcer import Announcer
from vehicle_agent.hmi.attention import Attention
from vehicle_agent.hmi.signalling import VehicleSignalling
from vehicle_agent.lidar.plausibility import CloudLimits
from vehicle_agent.link import client, clock, outbox, scan_uploads, session, upload
from vehicle_agent.localization.gnss_ins import GnssInsLocalization
from vehicle_agent.localization.laser.dead_reckoning import DeadReckoningParams
from vehicle_agent.localization.laser.point_to_line import MatchParams
from vehicle_agent.localization.laser.surfaces import SurfaceParams
from vehicle_agent.localization.monte_carlo.global_search import GlobalSearchParams
from vehicle_agent.localization.monte_carlo.likelihood_field import FieldParams
from vehicle_agent.localization.monte_carlo.localization import MonteCarloParams
from vehicle_agent.localization.odometry.lidar_odometry import OdometryParams
from vehicle_agent.localization.odometry_ekf import OdometryNoise
from vehicle_agent.localization.planar_map.agreement import EvidenceParams
from vehicle_agent.localization.planar_map.localizer import PlanarLocalizerParams
from vehicle_agent.localization.planar_map.place_finder import PlaceFinderParams
from vehicle_agent.localization.planar_map.place_search import PlaceSearchParams
from vehicle_agent.localization.scan_map.fusion import ScanMapLocalization
from vehicle_agent.localization.scan_map.localizer import LocalizerParams
from vehicle_agent.localization.scan_map.matching import MatchParams as ScanMatchParams
from vehicle_agent.mission.rules import MissionRules
from vehicle_agent.mission.seat_button import StopRules
from vehicle_agent.onboard import cabin_view
from vehicle_agent.perception.camera.conditions import CameraRules
from vehicle_agent.perception.cells import HeightMapPerception
from vehicle_agent.perception.height_map import HeightMap
from vehicle_agent.perception.kerbs import KerbMemory
from vehicle_agent.perception.laser_people.people import LaserPeople
from vehicle_agent.perception.laser_people.segments import SegmentParams
from vehicle_agent.perception.laser_people.tracking import LaserTracker
from vehicle_agent.perception.laser_people.verification import PersonVerification
from vehicle_agent.perception.pillars.decoding import DecodingParams
from vehicle_agent.perception.pillars.grid import PillarGrid
from vehicle_agent.perception.points.clusters import ClusterParams
from vehicle_agent.perception.points.grid import PointGrid
from vehicle_agent.perception.points.kinds import KindGates
from vehicle_agent.perception.signs.boards import BoardRules
from vehicle_agent.perception.signs.stages import SignStages
from vehicle_agent.perception.signs.tracks import SignTracker
from vehicle_agent.perception.thinned_scans import ScanThinning
from vehicle_agent.perception.tracker import AlphaBetaTracker
from vehicle_agent.perception.tracking.params import TrackerParams
from vehicle_agent.perception.tracks import TrackingPerception
from vehicle_agent.planning.waypoint.signs import SignRule
from vehicle_agent.runtime.processes import screen_process, supervisor, tick_process
from vehicle_agent.runtime.processes.sensing import scan_process, video_process
from vehicle_agent.runtime.recording import scan_keeper, scan_parcels
from vehicle_agent.runtime.screen import screen_requests
from vehicle_agent.runtime.video import (
    coarse,
    disk_room,
    outgoing,
    picture_checks,
    segment_file,
    wanted_spans,
)
from vehicle_agent.runtime.video.cameras_file import CameraEntry, VideoSettings
from vehicle_agent.signals import rates
from vehicle_agent.world.area_monitor import AreaMonitor
from vehicle_agent.world.camera_trust import TrustRules
from vehicle_agent.world.observed import ObservedWorld
from vehicle_agent.world.prediction import Predictor
from vehicle_agent.world.surroundings import Surroundings
from vehicle_agent.world.view import VisibilityParams

PAGES: dict[str, tuple[Any, ...]] = {
    "odometry": (OdometryParams,),
    "scan-map": (LocalizerParams, ScanMatchParams, ScanMapLocalization),
    "onboard": (rates,),
    "guard": (Guard, Avoidance, Limits),
    "gate": (GateSettings,),
    "can": (handshake, module_state, consistency, watchdog),
    "mission": (MissionRules, StopRules),
    "link": (session, clock, client, outbox, upload),
    "world": (Surroundings, Predictor, VisibilityParams, AreaMonitor, ObservedWorld, TrustRules),
    "perception": (
        HeightMap,
        HeightMapPerception,
        AlphaBetaTracker,
        TrackingPerception,
        KerbMemory,
        ScanThinning,
    ),
    "points": (PointGrid, ClusterParams, KindGates),
    "object-tracking": (TrackerParams,),
    "camera": (CameraRules, SegmentParams, LaserTracker, PersonVerification, LaserPeople),
    "signs": (SignStages, BoardRules, SignTracker, SignRule),
    "lidar": (CloudLimits,),
    "detector": (PillarGrid, DecodingParams),
    "localization": (GnssInsLocalization, OdometryNoise),
    "laser": (
        DeadReckoningParams,
        SurfaceParams,
        MatchParams,
        MonteCarloParams,
        FieldParams,
        GlobalSearchParams,
        PlanarLocalizerParams,
        EvidenceParams,
        PlaceFinderParams,
        PlaceSearchParams,
    ),
    "hmi": (Announcer, Attention, VehicleSignalling),
    "runtime": (supervisor, tick_process),
    "video": (
        VideoSettings,
        CameraEntry,
        wanted_spans,
        segment_file,
        outgoing,
        coarse,
        disk_room,
        picture_checks,
        video_process,
    ),
    "scans": (scan_parcels, scan_keeper, scan_process, scan_uploads),
    "screen": (screen_process, screen_requests, cabin_view),
}


@pytest.mark.parametrize("page", PAGES)
def test_a_page_gives_the_defaults_of_its_room(page: str) -> None:
    assert differing(f"vehicle/{page}.md", PAGES[page]) == []
