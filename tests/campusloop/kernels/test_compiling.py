"""Every group can be compiled, and a command's own cover what it drives."""

from importlib import import_module

import pytest

from campusloop.kernels.compiling import PACKAGES
from campusloop.kernels.groups import EVERYTHING, GROUPS, for_campus
from vehicle_agent.config import Profile


@pytest.mark.parametrize("name", EVERYTHING)
def test_a_groups_function_is_there_and_lies_in_our_packages(name: str) -> None:
    module, function = GROUPS[name].warm.split(":")
    assert callable(getattr(import_module(module), function))
    assert module.split(".")[0] in PACKAGES


@pytest.mark.parametrize("stack", ["gem", "nus", "snow_lion"])
def test_a_campus_needs_known_groups_and_one_stack_alone(stack: str) -> None:
    needed = set(for_campus(stack))
    assert needed <= set(EVERYTHING)
    assert needed & {"gem", "nus", "snow_lion"} == {stack}


def test_the_default_shuttle_has_a_group() -> None:
    assert Profile().stack in GROUPS
