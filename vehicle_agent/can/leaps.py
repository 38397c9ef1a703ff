"""Speed reports that leap: most likely a bit that was flipped on the bus past its own checks."""

# No road vehicle's speed changes faster; the allowance covers resolution and wheel slip.
_LEAP_MPS2, _LEAP_MPS = 15.0, 1.0

Report = tuple[float, int]


def leaps(speed_mps: float, stamp_ns: int, known: Report, doubted: Report) -> bool:
    """Whether a speed is too far from the last known one to be believed before a second one agrees.

    known, doubted: (speed, stamp) of the last report that was believed, and of the last that was not; stamp 0
    for none.
    """
    if known[1] == 0:
        return False
    heard = (known, doubted) if doubted[1] > known[1] else (known,)
    return all(
        abs(speed_mps - before_mps) > _LEAP_MPS + _LEAP_MPS2 * max(stamp_ns - before_ns, 0) * 1e-9
        for before_mps, before_ns in heard
    )
