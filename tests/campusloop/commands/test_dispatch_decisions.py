"""`campusloop dispatch explain` and `replay` on a database as a server leaves it."""

import json
import shutil
from datetime import timedelta
from pathlib import Path

import pytest
from typer.testing import CliRunner

from campusloop.cli import app_of
from server.domain.rides.rides import Ride, RideState
from server.loops.dispatcher import Dispatcher
from server.loops.solver import InlineSolver
from server.store import tables
from server.store.engine import open_engine
from tests.server.usecases.campus_under_test import CampusUnderTest
from tests.server.usecases.fake_fleet import FakeFleet
from tests.server.usecases.fresh_database import write_fresh_database
from tests.server.usecases.shipped_maps import shipped_map

RUN = CliRunner()
DAY = "2026-11-23"
WISHES = (("NN7", "NN20"), ("NN20", "C1"), ("C6", "GYM"), ("GYM", "NN7"), ("C1", "SE13"), ("SE13", "C6"))


@pytest.fixture(scope="module")
def database(tmp_path_factory: pytest.TempPathFactory) -> str:
    """Bookings, the first while one shuttle is in service alone; then others take some of them over."""
    path = tmp_path_factory.mktemp("stored") / "campus.db"
    write_fresh_database(path)
    url = f"sqlite:///{path}"
    campus = CampusUnderTest(shipped_map("snow-lion"), engine=open_engine(url))
    fleet = FakeFleet(campus, shipped_map("snow-lion"), 3)
    for shuttle in fleet.shuttles:
        shuttle.connect()
    for number, wish in enumerate(WISHES):
        if number in (0, 4):
            for shuttle in fleet.shuttles[: number or 1]:
                shuttle.resume()
        earliest = campus.clock.now() + timedelta(seconds=100 * number)
        fleet.book(*wish, 1 + number % 2, earliest=earliest)
    refused = fleet.book("NN7", "C6", 2, wheelchairs=1)
    assert refused.state is RideState.REFUSED
    dispatcher = Dispatcher(campus.transactions, campus.bus, InlineSolver(), campus.ids, "snow-lion", 40)
    for _ in range(30):
        fleet.step()
        campus.wait_for(dispatcher.run_once())
    campus.close()
    return url


def stored(database: str) -> CampusUnderTest:
    return CampusUnderTest(shipped_map("snow-lion"), engine=open_engine(database))


def rides_of(database: str) -> tuple[Ride, ...]:
    campus = stored(database)
    rides = campus.read(lambda uow: uow.views.rides(limit=100))
    campus.close()
    return rides


def invoked(*words: str) -> tuple[int, str]:
    done = RUN.invoke(app_of(["dispatch"]), ["dispatch", *words])
    return done.exit_code, " ".join(done.output.split())


def test_a_ride_is_explained_by_code_as_by_id(database: str) -> None:
    ride = next(ride for ride in rides_of(database) if (ride.from_stop, ride.to_stop) == WISHES[-1])
    code, output = invoked("explain", ride.ride_code.lower(), "--database", database)
    assert code == 0, output
    assert "Asked: shuttle-1, shuttle-2, shuttle-3." in output
    assert "got it: pickup" in output
    assert "s worse." in output or "No other shuttle could" in output
    assert invoked("explain", ride.ride_id, "--database", database) == (0, output)


def test_the_database_of_a_demo_here_is_found_without_its_name(
    database: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "var" / "demo").mkdir(parents=True)
    shutil.copy(database.removeprefix("sqlite:///"), tmp_path / "var" / "demo" / "campusloop.db")
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("CAMPUSLOOP_DATABASE_URL", raising=False)
    monkeypatch.delenv("CAMPUSLOOP_VAR_DIR", raising=False)
    ride = rides_of(database)[0]
    assert invoked("explain", ride.ride_code) == invoked("explain", ride.ride_code, "--database", database)


def test_who_was_not_asked_is_named(database: str) -> None:
    ride = next(ride for ride in rides_of(database) if (ride.from_stop, ride.to_stop) == WISHES[0])
    output = invoked("explain", ride.ride_id, "--database", database)[1]
    assert "Asked: shuttle-1. Not asked, because they took no new rides: shuttle-2, shuttle-3." in output
    assert "No other shuttle could have taken it." in output


def test_a_refusal_is_explained_by_its_rule(database: str) -> None:
    ride = next(ride for ride in rides_of(database) if ride.state is RideState.REFUSED)
    code, output = invoked("explain", ride.ride_id, "--database", database)
    assert code == 0, output
    assert "Refused by the rule wheelchair: no shuttle has so many wheelchair places." in output
    assert "instead" in output


def test_an_improvement_tells_who_was_to_come_before(database: str) -> None:
    told = [invoked("explain", ride.ride_id, "--database", database)[1] for ride in rides_of(database)]
    moved = [words for words in told if "took it over" in words]
    assert moved
    assert all("Before, shuttle-" in words for words in moved)


def test_the_report_in_json_holds_no_secret(database: str, tmp_path: Path) -> None:
    ride = rides_of(database)[0]
    path = tmp_path / "ride.json"
    assert invoked("explain", ride.ride_id, "--database", database, "--json", str(path))[0] == 0
    report = json.loads(path.read_text())
    assert report["ride_code"] == ride.ride_code
    assert report["decisions"][0]["kind"] == "booking"
    assert {"token", "boarding_code"}.isdisjoint(report)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("explain", "NOBODY"), "no ride has the code or id NOBODY"),
        (("replay", "2026-11-22"), "no decision of 2026-11-22 is stored"),
        (("replay", "yesterday"), "yesterday is not a date"),
        (("what-if", "2026-11-22"), "there are no rides in 2026-11-22"),
    ],
)
def test_what_is_not_there_ends_with_2(database: str, words: tuple[str, ...], said: str) -> None:
    code, output = invoked(*words, "--database", database)
    assert code == 2
    assert said in output


def test_a_missing_database_is_named_and_not_made(tmp_path: Path) -> None:
    code, output = invoked("explain", "NOBODY", "--database", f"sqlite:///{tmp_path}/none.db")
    assert code == 2
    assert "there is no database" in output
    assert not list(tmp_path.iterdir())


def test_every_decision_of_the_day_comes_out_the_same(database: str) -> None:
    code, output = invoked("replay", DAY, "--database", database)
    assert code == 0, output
    assert "are the same, bit for bit" in output
    assert "7 booking" in output
    assert "improvement" in output


def test_a_decision_that_comes_out_otherwise_is_named_and_ends_with_1(database: str, tmp_path: Path) -> None:
    path = tmp_path / "changed.db"
    path.write_bytes(Path(database.removeprefix("sqlite:///")).read_bytes())
    changed = f"sqlite:///{path}"
    engine, column = open_engine(changed), tables.decisions.c
    with engine.begin() as connection:
        row = connection.execute(tables.decisions.select().where(column.kind == "booking")).first()
        assert row is not None
        answer = json.loads(row.answer)
        answer[0]["best"]["pickup_s"] += 1.0
        spoiled = json.dumps(answer, separators=(",", ":")).encode()
        connection.execute(
            tables.decisions.update().where(column.decision_id == row.decision_id).values(answer=spoiled)
        )
    engine.dispose()
    code, output = invoked("replay", DAY, "--database", changed)
    assert code == 1
    assert "pickup_s was" in output


def test_a_stored_day_can_be_tried_with_a_shuttle_less(database: str) -> None:
    code, output = invoked("what-if", DAY, "--database", database, "--vehicles", "-1")
    assert code == 0, output
    assert "7 rides of" in output
    assert "2 shuttles" in output
