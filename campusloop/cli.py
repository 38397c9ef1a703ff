"""The command line. Each command is a file in `commands/`; this one only hangs them up."""

import typer

from campusloop.commands import agent, demo, openapi, replay, serve, simulate, warm
from campusloop.commands import map as campus_map

app = typer.Typer(
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    help="A campus fleet of autonomous shuttles: booking, dispatch, driving, live view and replay.",
)
app.add_typer(campus_map.app, name="map", help="Campus maps: import, check, rebuild.")
app.add_typer(agent.app, name="agent", help="The agent on a vehicle: enrol, run.")
app.command("demo")(demo.demo)
app.command("serve")(serve.serve)
app.command("simulate")(simulate.simulate)
app.command("replay")(replay.replay)
app.command("openapi")(openapi.openapi)
app.command("warm", hidden=True)(warm.warm)


def main() -> None:
    app()


if __name__ == "__main__":
    main()
