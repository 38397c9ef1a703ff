"""Set-up compiles what a proof runs, so that no bound's time has the compiler in it."""

import importlib
import pkgutil
from types import ModuleType

import campusloop.studies.bound
from campusloop.studies.bound.network import network_of
from campusloop.studies.bound.progress import Limits
from campusloop.studies.bound.proof import prove
from campusloop.studies.bound.warm import warm_kernels
from tests.campusloop.studies.bound.small_instances import a_ring

MODULES: tuple[ModuleType, ...] = tuple(
    importlib.import_module(f"campusloop.studies.bound.{module.name}")
    for module in pkgutil.iter_modules(campusloop.studies.bound.__path__)
)


def compiled() -> dict[str, int]:
    """How many argument types each kernel has been compiled for."""
    return {
        f"{module.__name__}.{name}": len(value.signatures)
        for module in MODULES
        for name, value in vars(module).items()
        if hasattr(value, "signatures")
    }


def test_a_proof_uses_no_kernel_that_warming_left_out() -> None:
    warm_kernels()
    before = compiled()
    assert len(before) > 20
    for _ in prove(network_of(a_ring(10)), Limits(labels_max=20_000, enumeration_labels_max=40_000)):
        pass
    # test modules that ran earlier in this process may only have compiled more, never fewer
    assert compiled() == before
