"""Speed reports that leap: most likely a bit that flipped on the bus."""

# No road vehicle's speed changes faster; the allowance covers resolution and wheel slip.
_LEAP_MPS2, _LEAP_MPS = 15.0, 1.0


def is_doubted(
    values: dict[str, float], speed_mps: float, stamp_ns: int, field: str, stamp_field: str
) -> bool:
    """True if a speed is too far from the last ones to be plausible; noted in `values`.

    A second report that agrees with a doubted one is accepted.
    values  a codec's reports: the last accepted speed in `field`, its stamp in `stamp_field` (0 for none),
            and a doubted one since then in `doubted_mps`, `doubted_ns`
    """
    references = [(values[field], values[stamp_field])]
    if values["doubted_ns"]:
        references.append((values["doubted_mps"], values["doubted_ns"]))
    doubted = values[stamp_field] > 0 and all(
        abs(speed_mps - before_mps) > _LEAP_MPS + _LEAP_MPS2 * abs(stamp_ns - before_ns) * 1e-9
        for before_mps, before_ns in references
    )
    values["doubted_mps"], values["doubted_ns"] = (speed_mps, stamp_ns) if doubted else (0.0, 0)
    if doubted:
        values["malformed_ns"] = stamp_ns
    return doubted
