"""Telegrams as a SICK LMS1xx sends them (CoLa A)."""

import struct
from collections.abc import Sequence

# From SICK's telegram listing: 21 beams from 10 degrees on, in steps of half a degree.
PUBLISHED = (
    b"sRA LMDscandata 1 1 89A27F 0 0 343 347 27477BA9 2747813B 0 0 7 0 0 1388 168 0 1 DIST1 3F800000 00000000"
    b" 186A0 1388 15 8A1 8A5 8AB 8AC 8A6 8AC 8B6 8C8 8C2 8C9 8CB 8C4 8E4 8E1 8EB 8E0 8F5 908 8FC 907 906"
    b" 0 0 0 0 0 0"
)


def telegram(
    raw: Sequence[int],
    *,
    start_deg: float = -45.0,
    step_deg: float = 0.5,
    counter: int = 1,
    begun_us: int = 1_000_000,
    age_us: int = 20_000,
    status: int = 0,
    scale: float = 1.0,
    intensities: Sequence[int] | None = None,
    encoders: int = 0,
    turns_hz: float = 50.0,
) -> bytes:
    """STX to ETX; raw: distances in mm at a scale of 1."""

    def channel(name: str, values: Sequence[int], factor: float) -> str:
        start, step = round(start_deg * 10_000) % (1 << 32), round(step_deg * 10_000)
        head = f"{name} {struct.pack('>f', factor).hex().upper()} 00000000 {start:X} {step:X}"
        return " ".join([head, f"{len(values):X}", *(f"{value:X}" for value in values)])

    sent_us = (begun_us + age_us) % (1 << 32)
    head = f"sSN LMDscandata 1 1 89A27F 0 {status:X} {counter:X} {counter:X} {begun_us:X} {sent_us:X}"
    wheels = "".join(" 10 0" for _ in range(encoders))
    first = f" 0 0 7 0 0 {round(100 * turns_hz):X} 168 {encoders:X}{wheels}"
    wide = f" 1 {channel('DIST1', raw, scale)}"
    narrow = " 0" if intensities is None else f" 1 {channel('RSSI1', intensities, 1.0)}"
    return b"\x02" + (head + first + wide + narrow + " 0 0 0 0 0").encode() + b"\x03"
