"""`campusloop rides`: rides of a running server, over its API, with a developer token."""

import asyncio
import json
import re
import ssl
from collections.abc import Awaitable, Callable
from datetime import UTC, datetime
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NoReturn, TypeVar

import msgspec
import typer
from rich.console import Console

from campusloop.clients.connection_variables import SERVER_VARIABLE, TOKEN_VARIABLE

if TYPE_CHECKING:
    from campusloop_sdk import Campus, Ride

T = TypeVar("T")

EXIT_REFUSED = 1
EXIT_BAD_INPUT = 2
STATES = (
    "requested", "assigned", "boarding", "aboard", "completed", "refused", "cancelled", "no_show", "failed"
)  # fmt: skip

ENDED = ("completed", "refused", "cancelled", "no_show", "failed")

app = typer.Typer(no_args_is_help=True)

Server = Annotated[
    str, typer.Option(envvar=SERVER_VARIABLE, metavar="URL", help="http(s)://HOST:PORT of the server.")
]
Token = Annotated[
    str,
    typer.Option(
        envvar=TOKEN_VARIABLE,
        help="Developer token. Better the variable: other users of the machine see options.",
        show_default=False,
    ),
]
Certificate = Annotated[
    Path | None, typer.Option(help="PEM certificate to trust, if the server's is self-signed.")
]
AsJson = Annotated[bool, typer.Option("--json", help="For programs.")]
RideName = Annotated[
    str, typer.Argument(metavar="RIDE", help="Its id or its six-character code, as `rides list` shows them.")
]

HERE = "http://127.0.0.1:8080"


@app.command("list")
def list_rides(
    states: Annotated[
        list[str] | None, typer.Option("--state", help=f"{', '.join(STATES)}; repeated for several.")
    ] = None,
    vehicle: Annotated[str | None, typer.Option(help="Of this vehicle only.")] = None,
    limit: Annotated[int, typer.Option(min=1, help="How many at most.")] = 50,
    server: Server = HERE,
    token: Token = "",
    certificate: Certificate = None,
    as_json: AsJson = False,
) -> None:
    """List rides, the newest request first. Scope `read`."""
    unknown = set(states or ()).difference(STATES)
    if unknown:
        _refuse(f"--state {', '.join(sorted(unknown))}: there are {', '.join(STATES)}")

    async def work(campus: "Campus") -> "list[Ride]":
        found: list[Ride] = []
        async for ride in campus.rides.list(states, vehicle, min(limit, 200)):  # type: ignore[arg-type]
            found.append(ride)
            if len(found) == limit:
                break
        return found

    rides = _answer(server, token, certificate, work)
    if as_json:
        typer.echo(json.dumps([_facts(ride) for ride in rides], indent=1))
        return
    for ride in rides:
        requested = f"{ride.requested_at.astimezone(UTC):%Y-%m-%d %H:%M} UTC"
        typer.echo(
            f"{ride.ride_id}  {ride.ride_code}  {ride.state:<9}  {requested}"
            f"  {ride.from_stop} to {ride.to_stop}, {ride.party}  {ride.vehicle_id or '-'}"
        )
    if not rides:
        Console(stderr=True).print("no rides")


@app.command("show")
def show(
    ride: RideName,
    server: Server = HERE,
    token: Token = "",
    certificate: Certificate = None,
    as_json: AsJson = False,
) -> None:
    """Show a ride: its state, its shuttle, what was promised and what is expected. Scope `read`.

    Of several rides that had the code, the newest is shown.
    """

    async def work(campus: "Campus") -> "Ride":
        if not _is_code(ride):
            return await campus.rides.get(ride)
        return (await _rides_of_code(campus, ride))[0]

    _print(_answer(server, token, certificate, work), as_json)


@app.command("book")
def book(
    from_stop: Annotated[str, typer.Argument(help="A stop's id.")],
    to_stop: Annotated[str, typer.Argument(help="A stop's id.")],
    party: Annotated[int, typer.Option(min=1, help="How many people.")] = 1,
    wheelchairs: Annotated[int, typer.Option(min=0, help="How many of them in wheelchairs.")] = 0,
    at: Annotated[
        str | None,
        typer.Option(metavar="TIME", help="Not before, e.g. 2026-12-01T08:30+08:00; default: now."),
    ] = None,
    key: Annotated[
        str | None, typer.Option(help="Names the booking: a repeat with the same key books nothing.")
    ] = None,
    server: Server = HERE,
    token: Token = "",
    certificate: Certificate = None,
    as_json: AsJson = False,
) -> None:
    """Book a ride; ends with 1 if it is refused. Scope `drive`. --json has the link's secret too."""
    earliest = None if at is None else _moment(at)
    ride = _answer(
        server,
        token,
        certificate,
        lambda campus: campus.rides.book(
            from_stop, to_stop, party=party, wheelchairs=wheelchairs, earliest=earliest, key=key
        ),
    )
    _print(ride, as_json)
    if ride.state == "refused":
        raise typer.Exit(EXIT_REFUSED)


@app.command("cancel")
def cancel(
    ride: RideName,
    server: Server = HERE,
    token: Token = "",
    certificate: Certificate = None,
    as_json: AsJson = False,
) -> None:
    """Cancel a ride; who is aboard is let out as soon as possible. Scope `drive`; by its code also `read`.

    A code names the one ride that has it and has not ended.
    """

    async def work(campus: "Campus") -> "Ride":
        if not _is_code(ride):
            return await campus.rides.cancel(ride)
        open_ones = [one for one in await _rides_of_code(campus, ride) if one.state not in ENDED]
        if len(open_ones) != 1:
            _refuse(f"no ride with the code {ride} is open; see `campusloop rides show {ride}`")
        return await campus.rides.cancel(open_ones[0].ride_id)

    _print(_answer(server, token, certificate, work), as_json)


def _is_code(name: str) -> bool:
    """A ride's code; ids are longer. Boarding codes are the passengers' and too short to name a ride."""
    return re.fullmatch(r"[A-Za-z0-9]{6}", name) is not None


async def _rides_of_code(campus: "Campus", code: str) -> "list[Ride]":
    """Newest first, at least one."""
    found = [one async for one in campus.rides.list(ride_code=code)]
    if not found:
        _refuse(f"no ride has the code {code}; see `campusloop rides list`")
    return found


def _answer(server: str, token: str, certificate: Path | None, work: "Callable[[Campus], Awaitable[T]]") -> T:
    """What the server answers; every failure ends the command with what to do."""
    if find_spec("campusloop_sdk") is None:
        _refuse("this needs the package for developers: pip install ./sdk/python")
    if not server.startswith(("http://", "https://")):
        _refuse(f"--server {server}: give http://HOST:PORT or https://HOST:PORT")
    if not token:
        _refuse(
            "no developer token: set CAMPUSLOOP_TOKEN, e.g. to what "
            "`campusloop token create --user operator --scope read --scope drive` prints"
        )
    # httpx sends headers in ASCII, and would fail on anything else with no word of the token.
    if not token.isascii() or not token.isprintable():
        _refuse("the developer token has characters that no token has; copy it again")
    from campusloop_sdk import CampusError, ConnectionLost, NotAllowed, connect

    async def ask() -> T:
        async with connect(server, token, tls=_tls(certificate)) as campus:
            return await work(campus)

    try:
        return asyncio.run(ask())
    except ConnectionLost as error:
        _refuse(
            f"no server answers at {server} ({error.__cause__}); start one (`campusloop demo`), or name it "
            "with --server or CAMPUSLOOP_SERVER"
        )
    except NotAllowed as error:
        _refuse(f"{error.detail}; `campusloop token create` makes one, where the server's database is")
    except CampusError as error:
        _refuse(str(error))


def _tls(certificate: Path | None) -> ssl.SSLContext | None:
    if certificate is None:
        return None
    try:
        return ssl.create_default_context(cafile=certificate)
    except OSError as error:
        _refuse(f"--certificate {certificate} cannot be used ({error})")


def _moment(text: str) -> datetime:
    try:
        at = datetime.fromisoformat(text)
    except ValueError:
        _refuse(f"--at {text} is no time; write it like 2026-12-01T08:30+08:00")
    if at.tzinfo is None:
        _refuse(f"--at {text} has no time zone; write it like {text}+08:00, or with Z for UTC")
    return at


def _print(ride: "Ride", as_json: bool) -> None:
    if as_json:
        typer.echo(json.dumps(_facts(ride), indent=1))
        return
    for label, text in _lines(ride):
        typer.echo(f"{label:<10}{text}")


def _lines(ride: "Ride") -> list[tuple[str, str]]:
    """Without the link's secret."""
    lines = [
        ("ride", f"{ride.ride_id} (code {ride.ride_code})"),
        ("state", ride.state + (f": {ride.reason_detail or ride.reason}" if ride.reason else "")),
        ("from, to", f"{ride.from_stop}, {ride.to_stop}"),
        ("party", f"{ride.party}" + (f", {ride.wheelchairs} in wheelchairs" if ride.wheelchairs else "")),
        ("shuttle", _shuttle(ride)),
    ]
    promise = ride.promise
    if promise is not None:
        window = f"pickup {_time(promise.pickup_from)} to {_time(promise.pickup_to)}"
        lines.append(("promised", f"{window}, there by {_time(promise.arrive_by)}"))
    if ride.pickup_eta is not None and ride.arrival_eta is not None:
        pickup = _range(ride.pickup_earliest, ride.pickup_latest, ride.pickup_eta)
        arrival = _range(ride.arrival_earliest, ride.arrival_latest, ride.arrival_eta)
        lines.append(("expected", f"pickup {pickup}, there {arrival}"))
    if ride.feedback is not None and ride.feedback.rating is not None:
        lines.append(("rated", f"{ride.feedback.rating} of 5"))
    boarding_code = getattr(ride, "boarding_code", "")
    return [*lines, ("boarding", f"code {boarding_code}")] if boarding_code else lines


def _shuttle(ride: "Ride") -> str:
    if ride.vehicle_id is None:
        return "none"
    name = ride.vehicle_name or ride.vehicle_id
    known = ride.vehicle_id if name == ride.vehicle_id else f"{name} ({ride.vehicle_id})"
    return known if ride.seats_left is None else f"{known}, {ride.seats_left} seats left"


def _range(earliest: datetime | None, latest: datetime | None, eta: datetime) -> str:
    """The range that is told; the planned time where none is."""
    if earliest is None or latest is None:
        return _time(eta)
    return f"{earliest.astimezone(UTC):%H:%M:%S} to {_time(latest)}"


def _facts(ride: "Ride") -> dict[str, Any]:
    facts: dict[str, Any] = msgspec.to_builtins(ride)
    return facts


def _time(at: datetime) -> str:
    return f"{at.astimezone(UTC):%H:%M:%S} UTC"


def _refuse(text: str) -> NoReturn:
    Console(stderr=True, soft_wrap=True, highlight=False).print(text, style="red", markup=False)
    raise typer.Exit(EXIT_BAD_INPUT)
