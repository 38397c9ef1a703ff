"""What can be looked at after a demo has ended, as commands to copy."""

import shlex
from pathlib import Path

# Where commands look for a demo by themselves.
DEMO_FOLDER = Path("var/demo")


def next_commands(folder: Path, ride_code: str | None, program: str) -> list[str]:
    """A line for each command.

    folder     of the demo; ride_code: of a ride to explain, None without one
    program    how the demo was called, so that the lines work where it was called from
    """
    name = shlex.quote(program) if Path(program).name == "campusloop" else "campusloop"
    lines = []
    if next(folder.rglob("*.mcap"), None) is not None:
        lines.append(f"replay in the browser: {name} view {shlex.quote(str(folder))}")
    if ride_code is not None:
        url = shlex.quote(f"sqlite:///{folder / 'campusloop.db'}")
        database = "" if folder == DEMO_FOLDER else f" --database {url}"
        lines.append(f"why the last ride got its shuttle: {name} dispatch explain {ride_code}{database}")
    return lines
