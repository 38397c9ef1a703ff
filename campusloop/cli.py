"""The command line. Each command is a file in `commands/`; this file registers them."""

import sys
from collections.abc import Iterable
from importlib import import_module

import typer

from vehicle_agent.runtime.processes.journal import write_journal

_COMMANDS = (
    "demo",
    "map",
    "serve",
    "agent",
    "simulate",
    "shuttles",
    "simulate-service",
    "scenario",
    "replay",
    "view",
    "runs",
    "rides",
    "waypoints",
    "workshop",
    "vehicle",
    "dispatch",
    "infrastructure",
    "sensors",
    "openapi",
    "backup",
    "restore",
    "doctor",
    "audit",
    "token",
    "warm",
)
_OPERATIONS = ("backup", "restore", "doctor", "audit", "token")
_GROUPS = {
    "map": "Campus maps: import, check, rebuild.",
    "scenario": "Scenario files: run them and check their expectations.",
    "agent": "The agent on a vehicle: enrol, run.",
    "dispatch": "Dispatch: explain, replay, what if; demand; bounds of published instances.",
    "audit": "The audit log: is its chain whole?",
    "token": "Developer tokens: create, list, revoke.",
    "infrastructure": "Cameras at crossings, and the time that they save.",
    "rides": "Rides of a running server: list, show, book, cancel.",
    "runs": "Recorded runs on disk: list, show, export.",
    "vehicle": "A vehicle's response: identify it from a recorded drive.",
    "sensors": "Sensors, live or recorded: check what they send.",
    "workshop": "Offline work on sensor logs: occupancy maps from laser logs, calibration of lidars.",
    "waypoints": "Waypoint files, of a route or of a recorded drive.",
}
_HIDDEN = ("warm",)


def app_of(names: Iterable[str] = _COMMANDS) -> typer.Typer:
    """The command line with these commands; only their files are imported."""
    app = typer.Typer(
        no_args_is_help=True,
        add_completion=False,
        pretty_exceptions_enable=False,
        help="A campus fleet of autonomous shuttles: booking, dispatch, driving, live view and replay.",
    )
    # Without a callback, an app of one command would treat that command's name as an argument.
    app.callback()(lambda: None)
    for name in names:
        folder = "operations." if name in _OPERATIONS else ""
        function = name.replace("-", "_")
        module = import_module(f"campusloop.commands.{folder}{function}")
        if name in _GROUPS:
            app.add_typer(module.app, name=name, help=_GROUPS[name])
        else:
            app.command(name, hidden=name in _HIDDEN)(getattr(module, function))
    return app


def main() -> None:
    """Import only the command that is named first: the others import a server or a vehicle."""
    named = [name for name in sys.argv[1:2] if name in _COMMANDS]
    write_journal(named[0] if named else "campusloop")
    app_of(named or _COMMANDS)()


if __name__ == "__main__":
    main()
