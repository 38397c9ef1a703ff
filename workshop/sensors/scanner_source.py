"""A planar scanner's telegrams, checked turn by turn."""

import math
from collections import Counter

import numpy as np

from vehicle_agent.lidar.cola import PlanarTurn, TelegramError, TelegramReader, turn_of
from workshop.sensors.source_report import Arrivals, SourceReport, counted

# SICK's planar scanners turn 15 to 50 times a second; some send every n-th turn.
_RATE_HZ = (4.5, 110.0)
# Of fewer beams with a return, something covers the scanner.
_RETURNS_MIN = 0.02


class ScannerCheck:
    """What a scanner sends that was asked for turns."""

    def __init__(self) -> None:
        self._reader, self._arrivals = TelegramReader(), Arrivals()
        self._says: Counter[str] = Counter()
        self._lost = 0
        self._newest: PlanarTurn | None = None

    def add(self, arrived_ns: int, data: bytes) -> None:
        for telegram in self._reader.add(data):
            try:
                turn = turn_of(telegram)
            except TelegramError as error:
                self._reader.refuse(error.code)
                continue
            if turn is not None:
                self._take(arrived_ns, turn)

    def _take(self, arrived_ns: int, turn: PlanarTurn) -> None:
        self._arrivals.add(arrived_ns)
        if turn.status:
            self._says[turn.status.replace(" ", "_")] += 1
        if np.isfinite(turn.ranges_m).mean() < _RETURNS_MIN:
            self._says["few_returns"] += 1
        if self._newest is not None:
            self._lost += (turn.counter - self._newest.counter - 1) % (1 << 16)
        self._newest = turn

    def report(self, name: str) -> SourceReport:
        what, turn = "no turns", self._newest
        if turn is not None:
            first, last = np.degrees(turn.angles_rad[[0, -1]])
            step_deg = math.degrees(turn.angles_rad[-1] - turn.angles_rad[0]) / max(
                len(turn.angles_rad) - 1, 1
            )
            what = f"planar scanner, {first:.0f} to {last:.0f} degrees in steps of {step_deg:.2f}"
        findings = [
            *self._arrivals.findings(*_RATE_HZ),
            *counted(self._reader.refused),
            *counted(dict(self._says)),
            *counted({"lost_turns": self._lost}),
        ]
        return SourceReport(
            name, what, len(self._arrivals.arrived_ns), self._arrivals.rate_hz, None, "none", tuple(findings)
        )
