"""Every group can be compiled, and a command's own cover what it drives."""

from importlib import import_module
from io import StringIO

import pytest
from rich.console import Console

from campusloop.kernels.caches import CachesNotWritable, KernelCaches
from campusloop.kernels.compiling import PACKAGES, prepare_kernels
from campusloop.kernels.groups import EVERYTHING, GROUPS, for_campus
from vehicle_agent.config import Profile


@pytest.mark.parametrize("name", EVERYTHING)
def test_a_groups_function_is_there_and_lies_in_our_packages(name: str) -> None:
    module, function = GROUPS[name].warm.split(":")
    assert callable(getattr(import_module(module), function))
    assert module.split(".")[0] in PACKAGES


@pytest.mark.parametrize("stack", ["gem", "nus", "snow_lion"])
def test_a_campus_needs_known_groups_and_one_stack_alone(stack: str) -> None:
    needed = set(for_campus(stack, by_scans=True, own_perception=True))
    assert needed <= set(EVERYTHING)
    assert needed & {"gem", "nus", "snow_lion"} == {stack}


def test_the_default_shuttle_has_a_group() -> None:
    assert Profile().stack in GROUPS


def test_a_command_starts_where_compiled_kernels_cannot_be_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its processes compile at each start; the user is told what the longer start comes from."""

    def refused(_caches: KernelCaches, _groups: tuple[str, ...]) -> tuple[str, ...]:
        raise CachesNotWritable("Read-only file system: kernels.json")

    monkeypatch.setattr(KernelCaches, "missing", refused)
    shown = StringIO()
    prepare_kernels(("gate",), Console(file=shown, width=200))
    assert "cannot be kept" in shown.getvalue()
    assert "Read-only file system" in shown.getvalue()
