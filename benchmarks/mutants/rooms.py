"""The rooms whose code is changed, and where their tests are."""

from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


@dataclass(frozen=True, slots=True)
class Room:
    """sources: files and folders of its code; tests: folders that mirror them.

    on_postgresql  whether the tests that mirror it run on PostgreSQL, too; all others run on SQLite alone
    """

    name: str
    sources: tuple[str, ...]
    tests: tuple[str, ...]
    on_postgresql: bool = False

    def files(self) -> tuple[str, ...]:
        """Every file of its code, relative to the root."""
        found: list[Path] = []
        for source in self.sources:
            path = ROOT / source
            found += [path] if path.is_file() else sorted(path.rglob("*.py"))
        return tuple(str(path.relative_to(ROOT)) for path in found if path.name != "__init__.py")


def _onboard(name: str) -> Room:
    return Room(name, (f"vehicle_agent/{name}",), (f"tests/vehicle_agent/{name}",))


_MOTION = "vehicle_agent/planning/motion"

ROOMS: tuple[Room, ...] = (
    *(_onboard(name) for name in ("guard", "gate", "can", "mission", "link", "world", "perception")),
    Room(
        "planning_checks",
        tuple(
            f"{_MOTION}/{name}.py" for name in ("agents", "checker", "clearance", "fallback", "validation")
        ),
        (f"tests/{_MOTION}",),
    ),
    # What Foxglove draws is left out: a shade of grey has no effect that a test could claim.
    Room(
        "contract",
        (
            "contract/geometry.py",
            "contract/roads",
            "contract/wire",
            *(f"contract/runlog/{name}.py" for name in ("arrays", "extent", "reader", "records", "writer")),
        ),
        ("tests/contract",),
    ),
    Room("domain", ("server/domain",), ("tests/server/domain",)),
    Room("usecases", ("server/usecases",), ("tests/server/usecases",)),
    Room("store", ("server/store",), ("tests/server/store",), on_postgresql=True),
    Room("fleet", ("server/fleet",), ("tests/server/fleet",)),
    Room("access", ("server/api/security",), ("tests/server/api/security", "tests/server/api/sessions")),
    Room("ecus", ("simulator/ecus",), ("tests/simulator/ecus",)),
)
