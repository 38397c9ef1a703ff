"""`campusloop simulate`: plant, by-wire, sensors and people of all vehicles, in real time.

With --km it drives whole campuses in virtual time and prints Table 2 of the Snow Lion paper for them.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, NoReturn

import typer
from rich.console import Console
from rich.markup import escape

from campusloop.campaigns.campaign import CampaignError
from campusloop.campaigns.choice import open_campaign
from campusloop.commands.localizing import Localization, chosen_point_map, chosen_profile
from campusloop.commands.perceiving import Perception, tell_lacks
from campusloop.kernels.compiling import ensure_kernels
from campusloop.kernels.groups import SIMULATOR, for_campus
from campusloop.live.simulation import simulate_vehicles
from campusloop.scenes.stacks import PROFILE_OF_STACK, perceiving, profile_of
from campusloop.shipped import PROFILES, SHIPPED_MAPS
from contract.localization_maps import LocalizationMapError
from contract.roads.load import MapError
from simulator.live.ports import BASE_PORT
from simulator.sensors.scene_lidars import scene_of_run
from vehicle_agent.config import ProfileError

_CONTACTS, _BAD_INPUT = 1, 2


@dataclass(frozen=True, slots=True)
class _LocalizedBy:
    localization: Localization
    point_map: Path | None
    scene: bool
    campus_sky: bool
    own_perception: bool = False

    def point_map_of(self, stack: str, campus_map: Path) -> Path | None:
        """Raises ProfileError, LocalizationMapError, MapError."""
        profile = chosen_profile(self.localization, PROFILES / PROFILE_OF_STACK.get(stack, ""))
        return chosen_point_map(
            self.localization, self.point_map, campus_map, has_scene=self.scene, profile=profile
        )


def simulate(
    map_path: Annotated[
        Path | None,
        typer.Option("--map", help="the campus map (map.json); with --km also: both shipped ones"),
    ] = None,
    vehicles: Annotated[str, typer.Option(help="vehicle ids, with commas between")] = "shuttle-1",
    profile_path: Annotated[
        Path | None, typer.Option("--profile", help="vehicle profile (TOML); default: the campus shuttle")
    ] = None,
    seed: Annotated[int, typer.Option(help="of noise and people")] = 1,
    base_port: Annotated[int, typer.Option(help="first of the loopback ports used")] = BASE_PORT,
    folder: Annotated[Path, typer.Option(help="folder of the lidars' scan rings")] = Path("var/simulation"),
    people: Annotated[bool, typer.Option(help="pedestrians around the shuttles")] = True,
    lidar: Annotated[bool, typer.Option(help="simulate the lidars")] = True,
    km: Annotated[float, typer.Option(min=0.0, help="drive this distance in virtual time instead")] = 0.0,
    stack: Annotated[str, typer.Option(help="with --km: snow_lion, gem or nus")] = "snow_lion",
    out: Annotated[Path | None, typer.Option(help="with --km: folder for figures, plots and samples")] = None,
    workers: Annotated[int, typer.Option(min=0, help="with --km: processes; 0: one a core")] = 0,
    cluster: Annotated[
        str | None, typer.Option(help="with --km: Dask scheduler (tcp://HOST:8786) whose workers drive")
    ] = None,
    plant_seed: Annotated[
        int | None, typer.Option(help="of the vehicles' dynamics; nominal ones without it")
    ] = None,
    scene: Annotated[
        bool,
        typer.Option("--scene", help="hills, kerbs, trees, parked vehicles, and lidars that see them"),
    ] = False,
    shift_s: Annotated[float, typer.Option(min=60.0, help="with --km: virtual time of one shift")] = 3600.0,
    localization: Annotated[
        Localization, typer.Option(help="with --km: by GNSS, or by scans on a map (needs --scene)")
    ] = Localization.GNSS,
    point_map: Annotated[
        Path | None, typer.Option(help="with --localization scans: the map's folder; needs --map")
    ] = None,
    campus_sky: Annotated[
        bool, typer.Option("--campus-sky", help="with --km: buildings hide and reflect satellites")
    ] = False,
    perception: Annotated[
        Perception,
        typer.Option(help="with --km: road users by a tracker of the truth, or own (needs --scene)"),
    ] = Perception.TRACKER,
) -> None:
    """Simulate vehicles in real time until Ctrl-C; each has a CAN bus of its own."""
    console = Console()
    if km > 0.0:
        maps = SHIPPED_MAPS if map_path is None else (map_path,)
        if point_map is not None and map_path is None:
            _refuse(console, "a point map is of one campus: name it with --map")
        own = perception is Perception.OWN
        if own and not scene:
            _refuse(console, "--perception own needs --scene, for its lidars to see people in")
        by = _LocalizedBy(localization, point_map, scene, campus_sky, own)
        _drive_km(console, maps, stack, km, seed, workers, cluster, shift_s, out, plant_seed, by)
        return
    agents = localization is not Localization.GNSS or perception is not Perception.TRACKER
    if agents or point_map is not None or campus_sky:
        _refuse(
            console,
            "agents localize the vehicles and find road users; these options are for drives with --km",
        )
    if map_path is None:
        _refuse(console, "give a campus map: --map maps/shanghai-university/map.json")
    ensure_kernels(SIMULATOR)
    vehicle_ids = tuple(name.strip() for name in vehicles.split(",") if name.strip())
    simulate_vehicles(
        map_path,
        vehicle_ids,
        profile_path,
        seed,
        base_port,
        folder,
        people,
        lidar,
        plant_seed=plant_seed,
        scene=scene_of_run(seed) if scene else None,
    )


def _drive_km(
    console: Console,
    maps: tuple[Path, ...],
    stack: str,
    km: float,
    seed: int,
    workers: int,
    cluster: str | None,
    shift_s: float,
    out: Path | None,
    plant_seed: int | None,
    localized: _LocalizedBy,
) -> None:
    """Exit 1 if there was a contact."""
    # This imports a whole campus with its server, which the simulation in real time does not need.
    from campusloop.studies.endurance.endurance_run import Surroundings, log_errors_only
    from campusloop.studies.endurance.ride_quality_report import NoDistanceDriven, report_km

    places = tuple(path.absolute() for path in maps)
    try:
        driven = profile_of(stack).stack
        by_scans = localized.localization is Localization.SCANS
        surroundings = {
            place: Surroundings(
                localized.scene,
                localized.campus_sky,
                localized.point_map_of(stack, place),
                localized.own_perception,
            )
            for place in places
        }
        own = localized.own_perception
        tell_lacks(console, perceiving(profile_of(stack), own))
        ensure_kernels(for_campus(driven, by_scans=by_scans, own_perception=own))
        with open_campaign(cluster, workers, log_errors_only, places) as campaign:
            contacts = report_km(
                console, campaign, places, stack, km, seed, shift_s, out, plant_seed, surroundings
            )
    except (
        MapError,
        ProfileError,
        LocalizationMapError,
        NoDistanceDriven,
        CampaignError,
        OSError,
    ) as error:
        _refuse(console, str(error))
    if contacts:
        raise typer.Exit(_CONTACTS)


def _refuse(console: Console, reason: str) -> NoReturn:
    console.print(f"[red]cannot simulate:[/red] {escape(reason)}", highlight=False)
    raise typer.Exit(_BAD_INPUT)
