"""Which kernels go together: what one command needs and another does not."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Group:
    """warm: "module:function" that calls every kernel of the group once; imported where it is called only."""

    name: str
    warm: str

    @property
    def module(self) -> str:
        return self.warm.split(":")[0]


# The longest first: what is begun last should not take longest. `bookings` comes after `search`, with which
# it shares most.
GROUPS = {
    group.name: group
    for group in (
        Group("search", "server.dispatch.engine.warm:warm_search"),
        Group("snow_lion", "vehicle_agent.stacks.warm:warm_snow_lion"),
        Group("bound", "campusloop.studies.bound.warm:warm_kernels"),
        Group("simulator", "simulator.warm:warm_kernels"),
        Group("gem", "vehicle_agent.stacks.warm:warm_gem"),
        Group("gate", "vehicle_agent.gate.footprint:warm_footprint"),
        Group("nus", "vehicle_agent.stacks.warm:warm_nus"),
        Group("bookings", "server.dispatch.warm:warm_bookings"),
        Group("fleet_size", "server.dispatch.engine.warm:warm_fleet_size"),
    )
}
EVERYTHING = tuple(GROUPS)
SERVER = ("search", "bookings")
SIMULATOR = ("simulator",)


def for_vehicle(stack: str) -> tuple[str, ...]:
    """What an agent with this stack needs."""
    return (stack, "gate")


def for_campus(stack: str) -> tuple[str, ...]:
    """What a server, a simulator and agents with this stack need."""
    return (*SERVER, *SIMULATOR, *for_vehicle(stack))
