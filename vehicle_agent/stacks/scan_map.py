"""Comparing the lidars' scans with a map of surfaces, for each stack that does it so."""

from pathlib import Path

from contract.point_map.map_files import read_index
from contract.roads.model import RoadMap
from vehicle_agent.config import Profile
from vehicle_agent.localization.gnss_ins import GnssInsLocalization
from vehicle_agent.localization.scan_map.fusion import ScanMapLocalization
from vehicle_agent.localization.scan_map.localizer import TileSource
from vehicle_agent.localization.scan_map.matcher import SurfaceMatcher
from vehicle_agent.localization.scan_map.stored_map import tile_source
from vehicle_agent.localization.worker import LocalizationWorker
from vehicle_agent.stacks.rooms import rear_slip_per_mps2


def localization(
    profile: Profile, road_map: RoadMap, *, by_scans: bool
) -> GnssInsLocalization | ScanMapLocalization:
    """GNSS, gyroscope and wheels in one filter; by_scans: and what a worker finds on a map of surfaces."""
    gnss = GnssInsLocalization(road_map.origin, slip_s2pm=rear_slip_per_mps2(profile))
    return ScanMapLocalization(gnss) if by_scans else gnss


def localization_worker(profile: Profile, folder: Path) -> LocalizationWorker:
    """What compares scans with the map of surfaces in a folder. Raises PointMapError."""
    index = read_index(folder)
    return LocalizationWorker(
        surface_matcher(profile, tile_source(folder, index), index.tile_m, index.voxel_m)
    )


def surface_matcher(profile: Profile, tiles: TileSource, tile_m: float, voxel_m: float) -> SurfaceMatcher:
    """For scans of the profile's vehicle, whose own body its lidars see. tile_m, voxel_m: of the map."""
    body = profile.body
    outline_m = (body.front_overhang_m, body.rear_overhang_m, 0.5 * body.width_m)
    return SurfaceMatcher(tiles, tile_m, voxel_m, outline_m)
