"""Groups of kernels: each is needed by some commands and not by others."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Group:
    """warm: "module:function", which calls every kernel of the group once; imported when it is called."""

    name: str
    warm: str

    @property
    def module(self) -> str:
        return self.warm.split(":")[0]


# The longest first, so that the last one to start is short. `bookings` comes after `search`, with which it
# shares most kernels.
GROUPS = {
    group.name: group
    for group in (
        Group("search", "server.dispatch.engine.warm:warm_search"),
        Group("snow_lion", "vehicle_agent.stacks.warm:warm_snow_lion"),
        Group("bound", "campusloop.studies.bound.warm:warm_kernels"),
        Group("simulator", "simulator.warm:warm_kernels"),
        Group("laser_mapping", "workshop.laser_mapping.warm:warm_kernels"),
        Group("cloud_mapping", "workshop.cloud_mapping.warm:warm_kernels"),
        Group("gem", "vehicle_agent.stacks.warm:warm_gem"),
        Group("odometry", "vehicle_agent.localization.odometry.warm:warm_odometry"),
        Group("scan_map", "vehicle_agent.localization.scan_map.warm:warm_scan_map"),
        Group("points", "vehicle_agent.perception.points.warm:warm_points"),
        Group("planar_map", "vehicle_agent.localization.planar_map.warm:warm_planar_map"),
        Group("detector", "vehicle_agent.perception.pillars.warm:warm_detector"),
        Group("laser_people", "vehicle_agent.perception.laser_people.warm:warm_laser_people"),
        Group("gate", "vehicle_agent.gate.footprint:warm_footprint"),
        Group("motion_calibration", "workshop.motion_calibration.warm:warm_kernels"),
        Group("nus", "vehicle_agent.stacks.warm:warm_nus"),
        Group("bookings", "server.dispatch.warm:warm_bookings"),
        Group("fleet_size", "server.dispatch.engine.warm:warm_fleet_size"),
    )
}
EVERYTHING = tuple(GROUPS)
SERVER = ("search", "bookings")
SIMULATOR = ("simulator",)
WORKSHOP = ("laser_mapping",)
CLOUD_MAPPING = ("odometry", "cloud_mapping")
DETECTOR = ("detector",)
MOTION_CALIBRATION = ("odometry", "motion_calibration")


def for_vehicle(stack: str, *, by_scans: bool = False, own_perception: bool = False) -> tuple[str, ...]:
    """The groups that an agent with this stack needs.

    by_scans: with a point map; own_perception: its worker finds and tracks road users
    """
    localization = ("planar_map" if stack == "nus" else "scan_map",) if by_scans else ()
    # A network looks at a Snow Lion's four lidars as well; the NUS cart has a laser for people.
    finders = {"snow_lion": ("detector",), "nus": ("laser_people",)}
    perception = ("points", *finders.get(stack, ())) if own_perception else ()
    return (stack, "gate", *localization, *perception)


def for_campus(stack: str, *, by_scans: bool = False, own_perception: bool = False) -> tuple[str, ...]:
    """The groups that a server, a simulator and agents with this stack need."""
    agents = for_vehicle(stack, by_scans=by_scans, own_perception=own_perception)
    return (*SERVER, *SIMULATOR, *agents)
