"""A small tree of sources with kernels, to be changed by tests."""

from pathlib import Path

from campusloop.kernels.groups import Group
from campusloop.kernels.sources import Sources

FILES = {
    "rooms/__init__.py": "",
    "rooms/compiled.py": (
        "from numba import njit\n\n\ndef kernel(function):\n    return njit(cache=True)(function)\n"
    ),
    "rooms/limits.py": "LEAST = 1.0\nMOST = 9.0\n",
    "rooms/values.py": (
        "from typing import NamedTuple\n\n\nclass Pose(NamedTuple):\n    x: float\n    y: float\n\n\n"
        "class Other(NamedTuple):\n    z: float\n"
    ),
    "rooms/lower.py": (
        "from numba import njit\n\nfrom rooms.limits import LEAST\n\n\n"
        "@njit(cache=True)\ndef twice(x):\n    return 2.0 * x + LEAST\n"
    ),
    "rooms/upper.py": (
        "from rooms.compiled import kernel\nfrom rooms.lower import twice\n"
        "from rooms.values import Pose\n\n\n"
        "@kernel\ndef length(pose: Pose) -> float:\n    return twice(pose.x) + pose.y\n\n\n"
        "def plain():\n    return 1\n"
    ),
    "rooms/alone.py": "from numba import njit\n\n\n@njit(cache=True)\ndef half(x):\n    return 0.5 * x\n",
    "rooms/warm.py": (
        "from rooms.upper import length\nfrom rooms.values import Pose\n\n\n"
        "def warm():\n    return length(Pose(1.0, 0.0))\n"
    ),
}
GROUPS = {"upper": Group("upper", "rooms.warm:warm"), "alone": Group("alone", "rooms.alone:half")}


def a_tree(root: Path) -> Path:
    for name, text in FILES.items():
        path = root / name
        path.parent.mkdir(exist_ok=True)
        path.write_text(text)
    return root


def change(root: Path, name: str, old: str, new: str) -> None:
    path = root / name
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))


def sources(root: Path) -> Sources:
    return Sources(root, ("rooms",))
