"""`campusloop token`: developer tokens, where the server's database is. It needs no server and no sign-in."""

import json
import os
import re
from collections.abc import Callable
from datetime import UTC, datetime
from typing import Annotated, Any, TypeVar, get_args

import typer
from rich.console import Console
from sqlalchemy.exc import ArgumentError

from campusloop.commands.operations.output import refuse
from campusloop.operations.campus_change import change_campus
from campusloop.operations.developer_tokens import TokenRequest, create_token, revoke_token
from campusloop.studies.dispatch.stored_campus import StoredCampusError, known_databases, stored_campus
from server.api.formats import NAME_PATTERN
from server.domain.errors import DomainError, TokenInvalid
from server.domain.record.identity import DeveloperToken, Scope
from server.settings import SettingsError, settings_from
from server.store.engine import DatabaseUnsupported, open_engine
from server.usecases.ports.unit_of_work import UnitOfWork

T = TypeVar("T")
VALID_DAYS_MAX = 366.0
SCOPES: tuple[Scope, ...] = get_args(Scope)

app = typer.Typer(no_args_is_help=True)

DatabaseUrl = Annotated[
    str | None,
    typer.Option(
        "--database", metavar="URL", help="Default: as in CAMPUSLOOP_*, or that of a demo that runs here."
    ),
]
User = Annotated[str, typer.Option(metavar="NAME", help="The admin in whose name; the demo's is `operator`.")]


@app.command("create")
def create(
    user: User,
    name: Annotated[str, typer.Option(help="What the token is for; shown in the lists.")] = "command-line",
    scopes: Annotated[
        list[str] | None,
        typer.Option("--scope", help=f"{', '.join(SCOPES)}; repeated for several; default: read."),
    ] = None,
    days: Annotated[float, typer.Option(help=f"How long it is valid, at most {VALID_DAYS_MAX:g}.")] = 30.0,
    database: DatabaseUrl = None,
) -> None:
    """Make a token and print it, once; nothing else goes to stdout. Only its hash is stored."""
    errors = _errors()
    if re.fullmatch(NAME_PATTERN, name) is None:
        refuse(errors, f"--name {name}: 1 to 64 letters, digits and . _ @ : - only, a letter or digit first")
    if not 0.0 < days <= VALID_DAYS_MAX:
        refuse(errors, f"--days {days:g}: more than 0, at most {VALID_DAYS_MAX:g}")
    given = scopes or ["read"]
    unknown = set(given).difference(SCOPES)
    if unknown:
        refuse(errors, f"--scope {', '.join(sorted(unknown))}: there are {', '.join(SCOPES)}")
    chosen = frozenset(scope for scope in SCOPES if scope in given)
    request = TokenRequest(user, name, chosen, days)
    made = _changed(errors, database, create_token(request))
    typer.echo(made.secret)
    errors.print(
        f"{made.token.token_id} ({name}) may {', '.join(sorted(made.token.scopes))} until "
        f"{made.token.expires_at:%Y-%m-%d %H:%M} UTC. It is not shown again",
        markup=False,
    )


@app.command("list")
def list_tokens(
    as_json: Annotated[bool, typer.Option("--json", help="For programs.")] = False,
    database: DatabaseUrl = None,
) -> None:
    """List the tokens, newest first, without their secrets."""
    errors = _errors()
    try:
        with stored_campus(_database(errors, database)) as uow:
            tokens, now = uow.identity.developer_tokens(), uow.now
    except StoredCampusError as error:
        refuse(errors, str(error))
    if as_json:
        typer.echo(json.dumps([_facts(token, now) for token in tokens], indent=1))
        return
    for token in tokens:
        scopes = ", ".join(sorted(token.scopes))
        typer.echo(
            f"{token.token_id}  {_state(token, now):<8} until {token.expires_at:%Y-%m-%d}  "
            f"{token.name}: {scopes}; by {token.made_by}"
        )
    if not tokens:
        errors.print("there are no developer tokens; `campusloop token create` makes one")


@app.command("revoke")
def revoke(
    token_id: Annotated[str, typer.Argument(metavar="TOKEN_ID", help="As `token list` shows it.")],
    user: User,
    database: DatabaseUrl = None,
) -> None:
    """End a token. Requests with it are refused at once, open connections end within 30 s."""
    errors = _errors()
    try:
        revoked = _changed(errors, database, revoke_token(user, token_id))
    except TokenInvalid as error:
        refuse(errors, f"{error.detail}; `campusloop token list` shows them")
    errors.print(f"{revoked.token_id} ({revoked.name}) is revoked", markup=False)


def _changed(errors: Console, database: str | None, work: Callable[[UnitOfWork], T]) -> T:
    """Raises TokenInvalid; all other refusals end the command."""
    url = _database(errors, database)
    try:
        # This looks first whether the database is there, of this version, and of one campus only.
        with stored_campus(url) as uow:
            campus_id = uow.campus_id
        return change_campus(url, campus_id, work)
    except TokenInvalid:
        raise
    except (StoredCampusError, SettingsError, DatabaseUnsupported) as error:
        refuse(errors, str(error))
    except DomainError as error:
        refuse(errors, error.detail)


def _database(errors: Console, database: str | None) -> str | None:
    """The only database that can be meant; it is named, since a token of another one opens nothing."""
    try:
        urls = known_databases(database)
        if len(urls) > 1:
            refuse(
                errors,
                f"there are several databases here: {', '.join(map(str, urls))}; choose with --database",
            )
        shown = open_engine(settings_from(os.environ, database_url=urls[0]).database()).url
    except (StoredCampusError, SettingsError, DatabaseUnsupported, ArgumentError) as error:
        refuse(errors, str(error))
    errors.print(f"database {shown.render_as_string(hide_password=True)}", style="dim", markup=False)
    return urls[0]


def _facts(token: DeveloperToken, now: datetime) -> dict[str, Any]:
    return {
        "token_id": token.token_id,
        "name": token.name,
        "scopes": sorted(token.scopes),
        "state": _state(token, now),
        "made_by": token.made_by,
        "created_at": token.created_at.astimezone(UTC).isoformat(),
        "expires_at": token.expires_at.astimezone(UTC).isoformat(),
    }


def _state(token: DeveloperToken, now: datetime) -> str:
    if token.revoked_at is not None:
        return "revoked"
    return "valid" if token.is_valid(now) else "expired"


def _errors() -> Console:
    return Console(stderr=True, soft_wrap=True, highlight=False)
