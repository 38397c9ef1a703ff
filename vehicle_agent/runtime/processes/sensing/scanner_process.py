"""Planar scanners of a real vehicle as a process: telegrams in, turns of their mirrors into rings.

A scanner that ends, is silent or cannot be reached is asked again, and none waits for another.
"""

import asyncio
from pathlib import Path

import numpy as np
import structlog

from contract.geometry import Array
from vehicle_agent.config import PlanarScanner
from vehicle_agent.device_feed import ScanRing
from vehicle_agent.lidar.cola import (
    START_TURNS,
    PlanarTurn,
    ScannerRefusal,
    TelegramError,
    TelegramReader,
    turn_of,
)
from vehicle_agent.runtime.processes.clock import Clock
from vehicle_agent.runtime.sensors.addresses import Address
from vehicle_agent.runtime.sensors.streams import Stream, open_stream

log = structlog.get_logger()

OPEN_AGAIN_S = 1.0
# A scanner sends 25 or 50 turns a second. One that is unplugged ends no connection.
SILENT_S = 1.0
TELL_AGAIN_NS = 10_000_000_000
# What a scanner's clock may say of a turn's age; of more, the clock was set.
_AGE_S_MAX = 0.5
# Angles of the profile and of the turns that differ by more are told of.
_ALIKE_RAD = 0.01


class PlacedScanner:
    """One scanner: its turns at the profile's rate into its ring, base frame, stamped by the middle beam."""

    def __init__(self, name: str, params: PlanarScanner, ring: Path) -> None:
        """ring: of the scanner's points. Raises DeviceFeedError."""
        self.name, self._params = name, params
        self._ring = ScanRing(ring, create=True)
        self._number, self._due_ns = 0, 0
        self._status, self._is_compared = "", False

    def take(self, came_ns: int, turn: PlanarTurn) -> None:
        """came_ns: when the turn's telegram came."""
        self._tell(turn)
        age_s = turn.age_s if turn.age_s <= _AGE_S_MAX else float(turn.offsets_s[-1] - turn.offsets_s[0])
        # A scanner that says less than its turn takes is not believed: nothing is seen before it happens.
        stamp_ns = came_ns - max(round(1e9 * (age_s + float(turn.offsets_s[0]))), 0)
        if stamp_ns < self._due_ns:
            return
        period_ns = round(1e9 / self._params.rate_hz)
        # Turns come a little early and late: the next one that is nearest to its time.
        self._due_ns = stamp_ns + period_ns - round(0.5e9 / self._params.mirror_hz)
        is_there = turn.ranges_m <= self._params.range_m_max
        self._ring.write(
            self._number,
            stamp_ns,
            points_base(turn, self._params)[is_there].astype(np.float32),
            turn.intensities[is_there].astype(np.float32),
            turn.offsets_s[is_there].astype(np.float32),
        )
        self._number += 1

    def _tell(self, turn: PlanarTurn) -> None:
        """Of what the scanner says of itself, and once of angles that the profile does not expect."""
        if turn.status != self._status:
            self._status = turn.status
            if turn.status:
                log.warning("scanner.not_well", name=self.name, says=turn.status)
            else:
                log.info("scanner.well", name=self.name)
        if self._is_compared:
            return
        self._is_compared = True
        field = float(turn.angles_rad[-1] - turn.angles_rad[0])
        step = field / max(len(turn.angles_rad) - 1, 1)
        expected, wanted_step = self._params.field_rad, self._params.step_rad
        if field < expected - _ALIKE_RAD or abs(step - wanted_step) > 0.1 * wanted_step:
            log.warning(
                "scanner.other_angles",
                name=self.name,
                field_rad=round(field, 4),
                step_rad=round(step, 5),
                profile_field_rad=round(expected, 4),
                profile_step_rad=round(wanted_step, 5),
            )


class ScannerProcess:
    """addresses: of the scanners, by their names in the profile."""

    def __init__(self, scanners: list[PlacedScanner], addresses: dict[str, Address], clock: Clock) -> None:
        self._scanners, self._addresses, self._clock = scanners, addresses, clock
        self._state: dict[str, str] = {}

    async def run(self, stop: asyncio.Event) -> None:
        """Until `stop`."""
        async with asyncio.TaskGroup() as group:
            tasks = [group.create_task(self._read(scanner)) for scanner in self._scanners]
            await stop.wait()
            for task in tasks:
                task.cancel()

    async def _read(self, scanner: PlacedScanner) -> None:
        """One scanner, for ever."""
        while True:
            try:
                stream = await open_stream(self._addresses[scanner.name])
            except OSError as error:
                self._tell(scanner.name, str(error) or "it does not answer")
                await asyncio.sleep(OPEN_AGAIN_S)
                continue
            try:
                await self._take_turns(scanner, stream)
                self._tell(scanner.name, "it has ended the connection")
            except TimeoutError:
                self._tell(scanner.name, "it is silent")
            except (ScannerRefusal, OSError) as error:
                self._tell(scanner.name, str(error))
            finally:
                stream.close()
            await asyncio.sleep(OPEN_AGAIN_S)

    async def _take_turns(self, scanner: PlacedScanner, stream: Stream) -> None:
        """Until the stream ends. Raises OSError, TimeoutError without a turn for a second, ScannerRefusal."""
        reader, refused = TelegramReader(), _Refused(scanner.name)
        await stream.write(START_TURNS)
        turned_ns = self._clock.now_ns()
        while True:
            async with asyncio.timeout(SILENT_S):
                data = await stream.read()
            if not data:
                return
            now_ns = self._clock.now_ns()
            for telegram in reader.add(data):
                try:
                    turn = turn_of(telegram)
                except ScannerRefusal:
                    raise
                except TelegramError as error:
                    reader.refuse(error.code)
                    continue
                if turn is not None:
                    scanner.take(now_ns, turn)
                    turned_ns = now_ns
                    self._tell(scanner.name, "")
            refused.tell(reader.refused, now_ns)
            if now_ns - turned_ns > 1e9 * SILENT_S:
                # It talks, but not of turns.
                raise TimeoutError

    def _tell(self, name: str, state: str) -> None:
        """When it changes; empty: turns come."""
        if self._state.get(name) == state:
            return
        self._state[name] = state
        if state:
            log.warning("sensor.not_open", name=name, error=state)
        else:
            log.info("sensor.open", name=name)


class _Refused:
    """Tells of what was refused, once in a while."""

    def __init__(self, name: str) -> None:
        self._name, self._told_ns, self._told = name, 0, dict[str, int]()

    def tell(self, refused: dict[str, int], now_ns: int) -> None:
        if refused != self._told and now_ns - self._told_ns >= TELL_AGAIN_NS:
            log.warning("scanner.refused_telegrams", name=self._name, **refused)
            self._told_ns, self._told = now_ns, dict(refused)


def points_base(turn: PlanarTurn, params: PlanarScanner) -> Array:
    """(n, 3) where the beams of a turn ended, base frame at each beam's own time."""
    angles = turn.angles_rad + params.yaw_rad
    x, y = turn.ranges_m * np.cos(angles), turn.ranges_m * np.sin(angles)
    points: Array = np.column_stack((params.x_m + x, params.y_m + y, np.full(len(angles), params.z_m)))
    return points
