"""The database of a campus is replaced by an older copy while its shuttles drive on."""

import shutil
import sqlite3
from contextlib import closing
from pathlib import Path

import pytest

from tests.scenarios.campus_days import CampusDay


def back_up(folder: Path) -> None:
    with (
        closing(sqlite3.connect(folder / "campus.db")) as database,
        closing(sqlite3.connect(folder / "backup.db")) as copy,
    ):
        database.backup(copy)


def restore(day: CampusDay, folder: Path) -> None:
    """What docs/server/operations.md says: stop the server, put the copy in its place, start it."""
    day.campus.stop_server()
    for file in folder.glob("campus.db*"):
        file.unlink()
    shutil.copy(folder / "backup.db", folder / "campus.db")
    day.campus.start_server()
    day.run_for(10.0)


def state_of_the_ride(day: CampusDay) -> str:
    (ride,) = day.campus.call(day.campus.client.get("/api/v1/rides")).json()
    return str(ride["state"])


@pytest.mark.long
@pytest.mark.parametrize(
    ("backed_up_when", "told"),
    [("aboard", "completed"), ("assigned", "no_show")],
)
def test_shuttles_take_rides_again_and_open_ones_end(
    day: CampusDay, tmp_path: Path, backed_up_when: str, told: str
) -> None:
    """The copy's ride was driven since. A party whose boarding is forgotten counts as absent."""
    before = day.request_ride(1)
    day.until_state(before, backed_up_when)
    back_up(tmp_path)
    day.until_state(before, "completed")
    day.run_for(40.0)
    assert day.campus.world.truth("shuttle-1").speed_mps > 1.0
    restore(day, tmp_path)
    shuttle = day.campus.call(day.campus.operator.vehicle("shuttle-1"))
    assert (shuttle["connected"], shuttle["held"], shuttle["placed"]) == (True, True, True)
    assert day.campus.world.truth("shuttle-1").speed_mps < 0.1, "what it drives on may be granted to others"
    day.campus.call(day.campus.operator.release("shuttle-1"))
    day.until(lambda: state_of_the_ride(day) == told, 400.0)
    # The doors of that visit close: they are not open for the next party.
    day.run_for(60.0)
    after = day.request_ride(2)
    day.until_state(after, "completed")
