"""All checks of an installation, in the order in which a person would mend what they find."""

from collections.abc import Mapping
from datetime import datetime

from campusloop.clients.connection_variables import SERVER_VARIABLE, TOKEN_VARIABLE
from campusloop.operations.database import check_database
from campusloop.operations.files import (
    check_certificate,
    check_folder,
    check_map,
    check_pages,
    check_push_key,
    check_ticket_keys,
)
from campusloop.operations.finding import Finding, bad, good, warning
from campusloop.operations.machine import check_clock, check_kernels, check_packages
from campusloop.operations.network import check_bus, check_port, check_segments
from server.settings import PREFIX, Settings, SettingsError, is_file_variable, settings_from


def examine(environment: Mapping[str, str], now: datetime, **options: object) -> tuple[Finding, ...]:
    """The findings for the settings that `serve` would read. Changes nothing.

    options: of the command line; those that are None are ignored
    """
    try:
        settings = settings_from(environment, **options)
    except SettingsError as error:
        # The other checks need the settings.
        broken = bad("settings", " ".join(str(error).split()), "set or unset the variables that are named")
        return check_packages(), broken, check_kernels(), check_clock(now, None)
    database, newest_record = check_database(settings)
    return (
        check_packages(),
        _check_settings(environment),
        check_folder(settings),
        check_ticket_keys(settings),
        check_push_key(settings),
        database,
        check_bus(settings),
        check_segments(settings),
        check_map(settings),
        check_pages(settings),
        check_certificate(settings, now),
        check_port(settings),
        check_clock(now, newest_record),
        check_kernels(),
    )


def _check_settings(environment: Mapping[str, str]) -> Finding:
    others = (SERVER_VARIABLE, TOKEN_VARIABLE)
    given = [name for name in environment if name.startswith(PREFIX) and name not in others]
    unknown = [
        name
        for name in given
        if name.removeprefix(PREFIX).lower() not in Settings.model_fields and not is_file_variable(name)
    ]
    if unknown:
        text = f"not a setting of the server, and ignored: {', '.join(sorted(unknown))}"
        return warning("settings", text, "correct the name, or unset it")
    return good("settings", f"valid; {len(given)} given as {PREFIX}*")
