"""Set-up compiles what the simulator runs, so that no step meets the compiler."""

from types import ModuleType

import contract.geometry
import simulator.scoring.metrics
import simulator.sensors.ray_hits
import simulator.traffic.corridor
import simulator.traffic.crowd
import simulator.traffic.outlines
import simulator.vehicle.plant
from simulator.warm import warm_kernels
from simulator.world import WorldOptions
from tests.simulator.street import a_world
from tests.simulator.traffic.careful_driver import CarefulDriver

MODULES: tuple[ModuleType, ...] = (
    contract.geometry,
    simulator.traffic.corridor,
    simulator.scoring.metrics,
    simulator.traffic.outlines,
    simulator.vehicle.plant,
    simulator.sensors.ray_hits,
    simulator.traffic.crowd,
)


def compiled() -> dict[str, int]:
    """How many argument types each kernel has been compiled for."""
    return {
        f"{module.__name__}.{name}": len(value.signatures)
        for module in MODULES
        for name, value in vars(module).items()
        if hasattr(value, "signatures")
    }


def test_no_step_of_a_world_uses_a_kernel_that_warming_left_out() -> None:
    warm_kernels()
    driver = CarefulDriver(a_world(WorldOptions()))
    before = compiled()
    assert len(before) > 15
    driver.drive(30.0)
    # test modules that ran earlier in this process may only have compiled more, never fewer
    assert compiled() == before
