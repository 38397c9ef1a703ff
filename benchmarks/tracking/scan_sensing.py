"""Each stack's own localization by its scans while it follows a curve: receiver, lidar, worker and filter."""

from collections import deque
from pathlib import Path

import msgspec
import numpy as np

from benchmarks.localization.drive import STEP_NS
from benchmarks.localization.sensed_drive import LEARNED_TICKS, SCAN_TICKS
from benchmarks.tracking.reference_paths import ReferencePath
from benchmarks.tracking.scan_site import ScanSite, scan_site
from simulator.sensors.gnss import GnssNoise, GnssReceiver
from simulator.sensors.imu import Imu, ImuNoise
from simulator.sensors.scene_lidars import SceneLidars
from simulator.traffic.actors import no_bodies
from simulator.vehicle.plant import PlantView
from vehicle_agent.config import Profile, load_profile
from vehicle_agent.localization.scan_map.fusion import ScanMapLocalization
from vehicle_agent.localization.worker import LocalizationWorker, ScanMatcher
from vehicle_agent.signals import Ego, Navigation, ScanAnswer, VehicleMotion
from vehicle_agent.signals.point_cloud import point_cloud
from vehicle_agent.stacks.nus import planar_localization, planar_matcher
from vehicle_agent.stacks.scan_map import localization, surface_matcher
from workshop.cloud_mapping.map_folder import TILE_M
from workshop.cloud_mapping.mapping import CloudMappingParams

_NUS = Path(__file__).resolve().parents[2] / "vehicle_agent" / "profiles" / "nus-cart.toml"
_VEHICLE = "shuttle"
_VOXEL_M = CloudMappingParams().surfaces.voxel_m
# From the end of a turn to its pose: the worker's time, and the mailboxes.
_DELAY_TICKS = 5
# A scanner on the roof's own level would see the roof's edge.
_MAST_M = 0.25


class ScannedCurve:
    """A curve on a campus, and how the vehicles of each stack know where on it they are.

    The NUS stack's planar scanner is on the roof of the vehicle that all stacks drive here.
    """

    def __init__(self, curve: ReferencePath, profile: Profile, stacks: list[str], seed: int = 1) -> None:
        """Maps the place once for each kind of map that the stacks need. Raises NoPlace."""
        self._site: ScanSite = scan_site(curve, seed)
        self._planar = _with_planar_scanner(profile)
        self._surfaces = self._site.surfaces() if {*stacks} - {"nus"} else {}
        self._occupancy = self._site.occupancy(self._planar) if "nus" in stacks else None

    @property
    def path(self) -> ReferencePath:
        """The curve, map frame."""
        return self._site.path

    def sensing(
        self, stack: str, profile: Profile, noise: GnssNoise, seed: int, silent_ticks: int = LEARNED_TICKS
    ) -> "ScanSensing":
        """Everything random is drawn from the seed. silent_ticks: when the receiver falls silent."""
        if stack == "nus":
            assert self._occupancy is not None, "the curve was mapped for this stack"
            room = planar_localization(profile, self._site.road_map)
            planar = planar_matcher(self._planar, self._occupancy, seed)
            return ScanSensing(self._site, self._planar, room, planar, noise, seed, silent_ticks)
        by_scans = localization(profile, self._site.road_map, by_scans=True)
        assert isinstance(by_scans, ScanMapLocalization)
        matcher = surface_matcher(profile, lambda ix, iy: self._surfaces.get((ix, iy)), TILE_M, _VOXEL_M)
        return ScanSensing(self._site, profile, by_scans, matcher, noise, seed, silent_ticks)


class ScanSensing:
    """Poses of one vehicle (`sensing.Sensing`), by scans alone once its receiver is silent."""

    def __init__(
        self, site: ScanSite, profile: Profile, room: ScanMapLocalization, matcher: ScanMatcher,
        noise: GnssNoise, seed: int, silent_ticks: int,
    ) -> None:  # fmt: skip
        rng = np.random.default_rng([seed, 2])
        origin = site.road_map.origin
        self._receiver, self._imu = GnssReceiver(origin, noise, rng), Imu(ImuNoise(), rng)
        self._lidars = SceneLidars(site.road_map, {_VEHICLE: profile}, site.options, 1)
        self._room, self._state, self._worker = room, room.initial(), LocalizationWorker(matcher)
        self._is_planar = profile.planar_scanner.rate_hz > 0.0
        self._due: deque[tuple[int, ScanAnswer]] = deque()
        self._silent_ticks = silent_ticks

    def __call__(self, now_ns: int, truth: PlantView, motion: VehicleMotion) -> Ego:
        tick = now_ns // STEP_NS
        self._receiver.silent = tick > self._silent_ticks
        fix = self._receiver.fix(now_ns, truth)
        items: list[Navigation] = [self._imu.sample(now_ns, truth)]
        items += [fix] if fix is not None else []
        while self._due and self._due[0][0] <= tick:
            items.append(self._due.popleft()[1])
        ego, self._state = self._room.step(self._state, motion, tuple(items), now_ns)
        for job in self._room.jobs(self._state):
            self._worker.take(job)
        self._take_scan(tick, now_ns, truth)
        return ego

    def _take_scan(self, tick: int, now_ns: int, truth: PlantView) -> None:
        is_due, bodies = tick % SCAN_TICKS == 0, no_bodies()
        scan = (
            self._lidars.planar_scan(_VEHICLE, now_ns, truth, bodies)
            if self._is_planar
            else self._lidars.scan(_VEHICLE, now_ns, is_due, truth, bodies)
        )
        if scan is None or not self._worker.is_ready(now_ns):
            return
        answer = self._worker.answer(point_cloud(now_ns, *scan))
        if answer is not None:
            self._due.append((tick + _DELAY_TICKS, answer))


def _with_planar_scanner(profile: Profile) -> Profile:
    """The profile with the NUS cart's scanner over the roof, in the place of its own lidar."""
    mount = msgspec.structs.replace(
        load_profile(_NUS).planar_scanner, x_m=profile.lidar.x_m, z_m=profile.body.height_m + _MAST_M
    )
    lidar = msgspec.structs.replace(profile.lidar, rate_hz=0.0)
    return msgspec.structs.replace(profile, planar_scanner=mount, lidar=lidar)
