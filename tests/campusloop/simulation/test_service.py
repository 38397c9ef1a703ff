"""The service in virtual time: the same for the same seed, clean, and not blind to a server that is wrong."""

import pytest

from campusloop.simulation.faults import KINDS
from server.usecases.rides import boarding
from tests.campusloop.simulation.conftest import Run


def test_a_seed_repeats_a_run_with_every_fault_and_no_rule_is_broken(run: Run) -> None:
    first, again = run(*KINDS, seed=4), run(*KINDS, seed=4)
    assert first.violations == []
    assert first.faults["torn-write"] > 0
    assert first.bookings > 0
    assert (first.digest, first.lines) == (again.digest, again.lines)


@pytest.mark.long
def test_a_server_that_believes_forged_events_is_found_out(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(boarding, "_ride_of", lambda uow, _vehicle_id, _what, ride_id: uow.rides.get(ride_id))
    assert any(run("forgery", seed=seed, hours=0.3).violations for seed in (1, 2, 3))
