"""A place is proven by scans in a row and by GNSS or a hint, never by one of them alone."""

from hypothesis import given
from hypothesis import strategies as st

from vehicle_agent.localization.proof import ProofState, Sighted, next_proof

SCANS = 5
AGREES = Sighted("tracking", True, False, False, False)
LOST = Sighted("lost", False, True, False, False)
sights = st.builds(
    Sighted,
    st.sampled_from(("waiting", "tracking", "doubtful", "lost", "recovered", "gnss_only")),
    st.booleans(),
    st.booleans(),
    st.booleans(),
    st.booleans(),
)


def run(seen: list[Sighted], state: ProofState = ProofState()) -> ProofState:
    for number, one in enumerate(seen):
        state = next_proof(state, one, SCANS, 1 + number)
    return state


@given(st.lists(sights, max_size=60))
def test_what_is_proven_was_lost_and_then_seen_and_confirmed(many: list[Sighted]) -> None:
    state = ProofState()
    for number, one in enumerate(many):
        after = next_proof(state, one, SCANS, 1 + number)
        if after.proven_ns != state.proven_ns:
            lost = max(k for k in range(number) if many[k].phase == "lost")
            last = many[number - SCANS + 1 : number + 1]
            assert all(seen.phase == "tracking" and not seen.disagreed for seen in last)
            assert one.is_confirmed or any(seen.is_hinted for seen in many[: number + 1])
            assert number - lost >= SCANS
        state = after


def test_scans_alone_prove_nothing() -> None:
    assert run([LOST] + [AGREES] * 1000).proven_ns == 0


def test_scans_with_gnss_or_after_a_hint_prove_the_place() -> None:
    with_gnss = Sighted("tracking", True, False, True, False)
    assert run([LOST] + [AGREES] * SCANS + [with_gnss]).proven_ns > 0
    hinted = Sighted("lost", False, False, False, True)
    assert run([LOST, hinted] + [AGREES] * SCANS).proven_ns > 0


def test_a_scan_that_disagrees_begins_the_proof_again() -> None:
    confirmed = Sighted("tracking", True, False, True, False)
    against = Sighted("tracking", False, True, True, False)
    early = run([LOST] + [confirmed] * (SCANS - 1) + [against] + [confirmed] * (SCANS - 1))
    assert early.is_open
    assert not next_proof(early, confirmed, SCANS, 99).is_open


def test_a_vehicle_that_was_never_lost_has_nothing_to_prove() -> None:
    assert run([AGREES] * 100) == ProofState()
