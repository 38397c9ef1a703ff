"""How far localization by scans has got: a state machine over what the room sees in each tick.

It names what is so, and decides when a vehicle in doubt has to stand. Every phase ends by itself: `lost` when
scans, GNSS or a hint give the place back.
"""

import msgspec

from contract.wire.reasons import LocalizationPhase


class Seen(msgspec.Struct, frozen=True):
    """What one tick shows.

    has_pose     a fix or a hint has told a place
    in_doubt     scans say that the pose may be wrong, and nothing confirms it
    placed_anew  the pose has been set to another place in this tick
    agrees       a scan has been believed in this tick
    has_map      the worker answers, and the map has something here
    way_m        odometer
    """

    has_pose: bool
    in_doubt: bool
    placed_anew: bool
    agrees: bool
    has_map: bool
    way_m: float


class PhaseRules(msgspec.Struct, frozen=True):
    """creep_m, creep_ns  so far and so long a vehicle in doubt may creep; then it is lost, and stands
    settled  scans that have to agree after the place was found again
    """

    creep_m: float = 10.0
    creep_ns: int = 30_000_000_000
    settled: int = 10


class PhaseState(msgspec.Struct, frozen=True):
    """since_ns, since_m  when the phase began; agreed: scans believed since then"""

    phase: LocalizationPhase = "waiting"
    since_ns: int = 0
    since_m: float = 0.0
    agreed: int = 0


def next_phase(state: PhaseState, seen: Seen, rules: PhaseRules, now_ns: int) -> PhaseState:
    """The state after a tick."""
    phase = _phase(state, seen, rules, now_ns)
    if phase != state.phase:
        return PhaseState(phase, now_ns, seen.way_m)
    return msgspec.structs.replace(state, agreed=state.agreed + seen.agrees)


def _phase(state: PhaseState, seen: Seen, rules: PhaseRules, now_ns: int) -> LocalizationPhase:
    if not seen.has_pose:
        return "waiting"
    if seen.in_doubt:
        if state.phase != "doubtful":
            return "lost" if state.phase == "lost" else "doubtful"
        crept = seen.way_m - state.since_m >= rules.creep_m or now_ns - state.since_ns >= rules.creep_ns
        return "lost" if crept else "doubtful"
    if not seen.has_map:
        return "gnss_only"
    if seen.placed_anew or state.phase == "lost":
        return "recovered"
    if state.phase == "recovered" and state.agreed < rules.settled:
        return "recovered"
    return "tracking"
