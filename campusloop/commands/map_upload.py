"""`campusloop map upload`: send a localization map to a running server, with a developer token."""

import ssl
from pathlib import Path
from typing import Annotated, NoReturn

import httpx
import typer
from rich.console import Console

from campusloop.clients.connection_variables import SERVER_VARIABLE, TOKEN_VARIABLE
from campusloop.clients.localization_upload import UploadError, upload_localization_map

_TIMEOUT_S = 60.0
_BAD_INPUT = 2
HERE = "http://127.0.0.1:8080"


def upload(
    folder: Annotated[
        Path, typer.Argument(metavar="FOLDER", help="A point map or an occupancy map in tiles.")
    ],
    note: Annotated[str, typer.Option(help="What it was made of, for operators.")] = "",
    server: Annotated[
        str, typer.Option(envvar=SERVER_VARIABLE, metavar="URL", help="http(s)://HOST:PORT of the server.")
    ] = HERE,
    token: Annotated[
        str,
        typer.Option(
            envvar=TOKEN_VARIABLE,
            help="Developer token of scope drive. Better the variable: other users see options.",
            show_default=False,
        ),
    ] = "",
    certificate: Annotated[
        Path | None, typer.Option(help="PEM certificate to trust, if the server's is self-signed.")
    ] = None,
) -> None:
    """Publish a localization map beside the one in force. An operator puts it in force on the console.

    Only tiles that the server lacks are sent; after a cut the same command goes on where it stopped.
    """
    if not server.startswith(("http://", "https://")):
        _refuse(f"--server {server}: give http://HOST:PORT or https://HOST:PORT")
    if not token:
        _refuse("no developer token: set CAMPUSLOOP_TOKEN to what `campusloop token create` prints")
    if not token.isascii() or not token.isprintable():
        _refuse("the developer token has characters that no token has; copy it again")
    headers = {"Authorization": f"Bearer {token}"}
    console = Console()
    try:
        verify = True if certificate is None else ssl.create_default_context(cafile=certificate)
        with (
            httpx.Client(base_url=server, headers=headers, verify=verify, timeout=_TIMEOUT_S) as client,
            console.status("sending the manifest") as status,
        ):
            sent = upload_localization_map(
                client,
                folder,
                note,
                lambda done, missing: status.update(f"{done} of {missing} missing tiles are sent"),
            )
    except UploadError as error:
        _refuse(str(error))
    except httpx.TransportError as error:
        _refuse(f"{server} does not answer ({error}); run the command again, and it goes on where it stopped")
    except OSError as error:
        _refuse(f"--certificate {certificate} cannot be used ({error})")
    console.print(
        f"{sent.kind} map {sent.map_version[:12]} is stored: {sent.tile_count} tiles, "
        f"{sent.size_bytes / 1e6:.1f} MB, of which {sent.sent} were sent",
        highlight=False,
    )
    console.print("put it in force on the console, under Maps", highlight=False)


def _refuse(text: str) -> NoReturn:
    Console(stderr=True, soft_wrap=True, highlight=False).print(text, style="red", markup=False)
    raise typer.Exit(_BAD_INPUT)
