"""A GNSS receiver: its bytes to solutions and fixes, whichever of NMEA 0183 and UBX it sends.

`pynmeagps` and `pyubx2` parse the messages; they are in the extra `workshop`.
"""

import math
from datetime import UTC, datetime
from typing import Any

from vehicle_agent.receivers.frames import FrameSplitter
from vehicle_agent.receivers.solutions import FixTracker, Solution
from vehicle_agent.signals import GnssFix

_MPS_PER_KNOT = 1852.0 / 3600.0
# Of a receiver that states no deviations: about what one of its metres of dilution is, without corrections.
_STD_M_PER_HDOP = 2.5


class ReceiverError(Exception):
    """Receivers cannot be read here; the message says what to do."""


class GnssReceiver:
    """One receiver; sans I/O.

    refused  messages by what is wrong: `bad_checksum` (or cut), `no_solution` (the receiver says so),
             `not_finite`; beside them are `FixTracker.no_heading`, `FrameSplitter.bad_checksums` and
             `skipped`
    other    whole messages that carry no position
    latest   the newest solution
    """

    def __init__(self) -> None:
        """ReceiverError without the parsers."""
        try:
            import pynmeagps
            import pyubx2
        except ModuleNotFoundError as error:
            raise ReceiverError("reading receivers needs the extra `workshop`: make workshop") from error
        self._nmea, self._ubx = pynmeagps, pyubx2
        self.frames, self.fixes = FrameSplitter(), FixTracker()
        self.refused: dict[str, int] = {}
        self.other = 0
        self.latest: Solution | None = None
        self._epoch: dict[str, Any] = {}
        self._has_gst = False

    def add(self, stamp_ns: int, data: bytes) -> list[GnssFix]:
        """The fixes that these bytes complete; stamp_ns: when they came, in the vehicle's clock."""
        found: list[GnssFix] = []
        for kind, frame in self.frames.add(data):
            solution = self._of_nmea(frame) if kind == "nmea" else self._of_ubx(frame)
            if solution is None:
                continue
            if not _is_finite(solution):
                self._refuse("not_finite")
                continue
            self.latest = solution
            fix = self.fixes.fix(stamp_ns, solution)
            if fix is not None:
                found.append(fix)
        return found

    def _of_ubx(self, frame: bytes) -> Solution | None:
        """NAV-PVT has everything in one message."""
        ubx = self._ubx
        try:
            message = ubx.UBXReader.parse(frame)
        except (ubx.UBXParseError, ubx.UBXMessageError, ubx.UBXTypeError, ubx.UBXStreamError):
            self._refuse("bad_checksum")
            return None
        if message.identity != "NAV-PVT":
            self.other += 1
            return None
        if not message.gnssFixOk or message.fixType not in (2, 3, 4):
            self._refuse("no_solution")
            return None
        return Solution(
                _ubx_utc_ns(message), message.lat, message.lon, 1e-3 * message.gSpeed,
                math.radians(message.headMot), math.radians(message.headVeh) if message.headVehValid else
                None, 1e-3 * message.hAcc,
        )  # fmt: skip

    def _of_nmea(self, frame: bytes) -> Solution | None:
        """Sentences of one epoch have one time; it is complete with RMC, GGA and, if it sends them, GST."""
        nmea = self._nmea
        try:
            message = nmea.NMEAReader.parse(frame)
        except (nmea.NMEAParseError, nmea.NMEAMessageError, nmea.NMEATypeError, nmea.NMEAStreamError):
            self._refuse("bad_checksum")
            return None
        # None is a sentence that the parser does not know.
        kind = None if message is None else message.msgID
        if kind not in ("RMC", "GGA", "GST", "HDT"):
            self.other += 1
            return None
        if kind == "GST":
            self._has_gst = True
        # HDT has no time: it belongs to the epoch that is being received.
        if kind != "HDT" and message.time != self._epoch.get("time"):
            self._epoch = {"time": message.time, "HDT": self._epoch.get("HDT")}
        self._epoch[kind] = message
        wanted = ("RMC", "GGA", "GST") if self._has_gst else ("RMC", "GGA")
        if kind == "HDT" or any(name not in self._epoch for name in wanted) or self._epoch.get("given"):
            return None
        self._epoch["given"] = True
        return self._of_epoch(self._epoch)

    def _of_epoch(self, epoch: dict[str, Any]) -> Solution | None:
        rmc, gga, gst, hdt = (epoch.get(name) for name in ("RMC", "GGA", "GST", "HDT"))
        epoch["HDT"] = None
        assert rmc is not None
        assert gga is not None
        if rmc.status != "A" or gga.quality in (0, "0", ""):
            self._refuse("no_solution")
            return None
        try:
            std_m = _STD_M_PER_HDOP * float(gga.HDOP)
            if gst is not None:
                std_m = max(float(gst.stdLat), float(gst.stdLong))
            return Solution(
                _nmea_utc_ns(rmc), float(gga.lat), float(gga.lon), _MPS_PER_KNOT * float(rmc.spd or 0.0),
                _angle_rad(rmc.cog), None if hdt is None else _angle_rad(hdt.headingT), std_m,
            )  # fmt: skip
        except (TypeError, ValueError):
            # An empty field where a number is due: the receiver has no solution, whatever its flags say.
            self._refuse("no_solution")
            return None

    def _refuse(self, code: str) -> None:
        self.refused[code] = self.refused.get(code, 0) + 1


def _angle_rad(degrees: Any) -> float | None:
    """An angle of a sentence, None where the field is empty."""
    return None if degrees in ("", None) else math.radians(float(degrees))


def _is_finite(solution: Solution) -> bool:
    values = (solution.latitude_deg, solution.longitude_deg, solution.speed_mps, solution.position_std_m)
    angles = (solution.course_rad or 0.0, solution.heading_rad or 0.0)
    return (
        all(map(math.isfinite, (*values, *angles)))
        and abs(solution.latitude_deg) <= 90.0
        and abs(solution.longitude_deg) <= 180.0
    )


def _ubx_utc_ns(message: Any) -> int | None:
    if not (message.validDate and message.validTime):
        return None
    try:
        whole = datetime(
            message.year, message.month, message.day, message.hour, message.min, message.second, tzinfo=UTC
        )
    except ValueError:
        # A leap second, or a clock that is being set.
        return None
    return int(whole.timestamp()) * 1_000_000_000 + int(message.nano)


def _nmea_utc_ns(rmc: Any) -> int | None:
    if not rmc.date or not rmc.time:
        return None
    moment = datetime.combine(rmc.date, rmc.time, tzinfo=UTC)
    return int(moment.timestamp()) * 1_000_000_000 + moment.microsecond * 1000
