"""`campusloop dispatch`: explain, repeat and vary the dispatcher's decisions; bounds of instances."""

import typer

from campusloop.commands.dispatch.bound import bound
from campusloop.commands.dispatch.demand import demand
from campusloop.commands.dispatch.explain import explain
from campusloop.commands.dispatch.replay import replay
from campusloop.commands.dispatch.what_if import what_if

app = typer.Typer(no_args_is_help=True)
for command in (explain, replay, what_if, demand, bound):
    app.command()(command)
