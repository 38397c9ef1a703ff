"""`campusloop serve`: the server; by default it listens on this machine only."""

from pathlib import Path
from typing import Annotated

import typer

from campusloop.kernels.compiling import ensure_kernels
from campusloop.kernels.groups import SERVER
from campusloop.live.server import serve_campus


def serve(
    host: Annotated[str | None, typer.Option(help="Address to listen on.")] = None,
    port: Annotated[int | None, typer.Option(help="TCP port.")] = None,
    tls_cert: Annotated[Path | None, typer.Option(help="PEM certificate chain.")] = None,
    tls_key: Annotated[Path | None, typer.Option(help="PEM private key.")] = None,
    tls_self_signed: Annotated[bool, typer.Option(help="Create a certificate under var/tls.")] = False,
    no_tls: Annotated[bool, typer.Option("--no-tls", help="Plain HTTP even on a network address.")] = False,
    campus_map: Annotated[Path | None, typer.Option("--map", help="Campus map to serve.")] = None,
) -> None:
    """Serve passengers, operators, vehicles and developers of one campus."""
    ensure_kernels(SERVER)
    serve_campus(host, port, tls_cert, tls_key, campus_map, tls_self_signed=tls_self_signed, no_tls=no_tls)
