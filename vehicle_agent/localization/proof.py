"""Whether the place of a vehicle that was lost is proven: by scans in a row, and by something else.

Scans alone may have found a place that looks alike. GNSS, or the place that an operator named, tells
them apart.
"""

import msgspec

from contract.wire.reasons import LocalizationPhase


class Sighted(msgspec.Struct, frozen=True):
    """What one tick shows.

    agreed, disagreed  a scan has been believed, or has come and has not
    is_confirmed       a fix that was believed since the loss is young, and agrees
    is_hinted          an operator has named the place in this tick
    """

    phase: LocalizationPhase
    agreed: bool
    disagreed: bool
    is_confirmed: bool
    is_hinted: bool


class ProofState(msgspec.Struct, frozen=True):
    """is_open    the vehicle has been lost, and its place is not proven yet
    scans      that agreed in a row since; hinted: an operator has named the place since
    proven_ns  when the last loss ended in a proof; 0 never
    """

    is_open: bool = False
    scans: int = 0
    hinted: bool = False
    proven_ns: int = 0


def next_proof(state: ProofState, seen: Sighted, scans_min: int, now_ns: int) -> ProofState:
    """The state after a tick; scans_min: so many scans in a row have to agree after the place was found."""
    if seen.phase == "lost":
        return ProofState(True, 0, seen.is_hinted or (state.hinted and state.is_open), state.proven_ns)
    if not state.is_open:
        return state
    scans = 0 if seen.disagreed or seen.phase != "tracking" else state.scans + seen.agreed
    hinted = state.hinted or seen.is_hinted
    if scans >= scans_min and (hinted or seen.is_confirmed):
        return ProofState(proven_ns=now_ns)
    return ProofState(True, scans, hinted, state.proven_ns)
