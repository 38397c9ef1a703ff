"""What a kernel's machine code depends on."""

from pathlib import Path

import pytest

from tests.campusloop.kernels.kernel_tree import a_tree, change, sources


def test_kernels_are_found_by_numbas_decorators_and_by_ours(tmp_path: Path) -> None:
    assert sources(a_tree(tmp_path)).kernels == {
        "rooms.alone": ("half",),
        "rooms.lower": ("twice",),
        "rooms.upper": ("length",),
    }


@pytest.mark.parametrize(
    ("name", "old", "new", "touched"),
    [
        ("rooms/lower.py", "2.0 * x", "3.0 * x", {"rooms.lower", "rooms.upper"}),
        ("rooms/limits.py", "LEAST = 1.0", "LEAST = 2.0", {"rooms.lower", "rooms.upper"}),
        ("rooms/values.py", "x: float\n    y: float", "y: float\n    x: float", {"rooms.upper"}),
        ("rooms/compiled.py", "cache=True", "cache=True, fastmath=True", {"rooms.upper"}),
        ("rooms/upper.py", "+ pose.y", "- pose.y", {"rooms.upper"}),
        ("rooms/alone.py", "0.5 * x", "0.25 * x", {"rooms.alone"}),
        ("rooms/limits.py", "MOST = 9.0", "MOST = 8.0", set()),
        ("rooms/values.py", "z: float", "w: float", set()),
        ("rooms/upper.py", "return 1", "return 2", set()),
        ("rooms/lower.py", "2.0 * x + LEAST", "2.0 * x + LEAST  # said", set()),
    ],
)
def test_a_change_touches_the_kernels_that_are_compiled_from_it(
    tmp_path: Path, name: str, old: str, new: str, touched: set[str]
) -> None:
    root = a_tree(tmp_path)
    before = sources(root)
    digests = {module: before.digest(module) for module in before.kernels}
    change(root, name, old, new)
    after = sources(root)
    assert {module for module in digests if after.digest(module) != digests[module]} == touched


def test_an_annotation_in_quotes_counts_as_well(tmp_path: Path) -> None:
    root = a_tree(tmp_path)
    change(root, "rooms/upper.py", "pose: Pose", 'pose: "Pose"')
    before = sources(root).digest("rooms.upper")
    change(root, "rooms/values.py", "x: float\n    y: float", "y: float\n    x: float")
    assert sources(root).digest("rooms.upper") != before


def test_a_module_imported_whole_counts_whole(tmp_path: Path) -> None:
    root = a_tree(tmp_path)
    change(root, "rooms/lower.py", "from rooms.limits import LEAST", "from rooms import limits")
    change(root, "rooms/lower.py", "+ LEAST", "+ limits.LEAST")
    before = sources(root).digest("rooms.upper")
    change(root, "rooms/limits.py", "LEAST = 1.0", "LEAST = 2.0")
    assert sources(root).digest("rooms.upper") != before


def test_imports_are_followed_through_our_own_modules(tmp_path: Path) -> None:
    found = sources(a_tree(tmp_path)).imported("rooms.warm")
    assert {"rooms.warm", "rooms.upper", "rooms.lower", "rooms.limits", "rooms.values"} <= found
    assert "rooms.alone" not in found
