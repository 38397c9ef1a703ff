"""Time to decide one booking with a busy fleet: all vehicles are considered, with runner-up and promise.

    python -m benchmarks.decisions --vehicles N --rides M [--decisions K] [--seed S] [--json FILE]

Shuttles among 200 stops serve M rides that are accepted and not over yet. The day goes on between decisions
as fast as keeps their number; that is timed apart (`advance`). Refusals count too, with the search for the
rule that binds and for alternatives.
"""

import argparse
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

from benchmarks.reporting.report import RunReport
from server.dispatch.answer import Answer, PromiseRules, answer_all
from server.dispatch.problem import Problem, Request, VehicleState, Walk
from server.dispatch.schedule.schedule import Schedule

_STOPS = 200
_SPEED_MPS = 4.0
# One shuttle for so much ground: the fleet is as dense whatever its size.
_GROUND_M2 = 250_000.0
_TERMS = PromiseRules(60.0, 300.0, 300.0, 0.5, 7200.0)
_WALK_M_MAX, _WALK_MPS = 400.0, 1.1


def main() -> None:
    report = RunReport()
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--vehicles", type=int, default=12)
    parser.add_argument("--rides", type=int, default=50)
    parser.add_argument("--decisions", type=int, default=2000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--json", type=Path)
    args = parser.parse_args()
    if args.vehicles < 1 or args.rides < 0 or args.decisions < 1:
        parser.error("there must be a vehicle, a decision, and no fewer than 0 rides")
    day = _Day(args.vehicles, args.rides, args.seed)
    day.fill(args.rides)
    row = day.measured(args.rides, args.decisions)
    report.write(
        args.json,
        "decisions",
        {name: getattr(args, name) for name in ("vehicles", "rides", "decisions", "seed")},
        [row],
        {key: row[key] for key in ("p50_ms", "p99_ms", "decisions_per_s")},
    )


class _Day:
    """A schedule and its clock."""

    def __init__(self, vehicles: int, rides: int, seed: int) -> None:
        self._rng = np.random.default_rng(seed)
        side_m = float(np.sqrt(_GROUND_M2 * vehicles))
        xy = self._rng.uniform(0.0, side_m, (_STOPS, 2))
        apart_m = np.linalg.norm(xy[:, None] - xy[None, :], axis=2)
        self._times = apart_m / _SPEED_MPS
        fleet = tuple(
            VehicleState(f"v{k}", self._times[int(self._rng.integers(_STOPS))], 0.0, 6, 1)
            for k in range(vehicles)
        )
        walks = tuple(
            tuple(
                Walk(int(other), float(row[other]) * 1.3 / _WALK_MPS)
                for other in np.argsort(row)[1:4]
                if row[other] <= _WALK_M_MAX
            )
            for row in apart_m
        )
        self._terms = replace(_TERMS, walks=walks)
        self._board = Schedule(Problem(fleet, {}, self._times, dwell_s=15.0), spare=rides + 200)
        self._now_s, self._number, self._carried = 0.0, 0, 0

    def fill(self, rides: int) -> None:
        """Take so many rides; the clock moves on a little for each, as it would in a morning."""
        refused = 0
        while self._carried < rides:
            before = self._carried
            self._answer_request()
            refused = refused + 1 if self._carried == before else 0
            if refused >= 50:
                self._advance(60.0)

    def measured(self, rides: int, decisions: int) -> dict[str, float | int]:
        took: list[float] = []
        advanced: list[float] = []
        refusals: list[float] = []
        accepted = 0
        for _ in range(decisions):
            began = time.perf_counter()
            while self._carried > rides:
                self._advance(1.0)
            advanced.append(time.perf_counter() - began)
            answer, seconds = self._answer_request()
            (refusals if answer.best is None else took).append(seconds)
            accepted += answer.best is not None
        every = 1e3 * np.array([*took, *refusals])
        return {
            "vehicles": len(self._board.vehicle_ids),
            "rides": rides,
            "decisions": decisions,
            "accepted": accepted,
            "p50_ms": round(float(np.percentile(every, 50)), 4),
            "p99_ms": round(float(np.percentile(every, 99)), 4),
            "worst_ms": round(float(every.max()), 3),
            "refusal_p99_ms": round(1e3 * float(np.percentile(refusals, 99)), 3) if refusals else 0.0,
            "decisions_per_s": round(1e3 / float(every.mean()), 1),
            "advance_p50_ms": round(1e3 * float(np.median(advanced)), 4),
        }

    def _answer_request(self) -> tuple[Answer, float]:
        self._number += 1
        pickup, dropoff = (int(place) for place in self._rng.choice(_STOPS, 2, replace=False))
        direct_s = float(self._times[pickup, dropoff])
        from_s = self._now_s + float(self._rng.uniform(0.0, 1800.0))
        request = Request(
            f"r{self._number}",
            pickup,
            dropoff,
            int(self._rng.integers(1, 4)),
            0,
            from_s,
            from_s + 1200.0,
            np.inf,
            max(2.0 * direct_s, direct_s + 600.0),
        )
        began = time.perf_counter()
        self._board.add(request)
        (answer,) = answer_all(self._board, [request.request_id], self._terms)
        seconds = time.perf_counter() - began
        self._carried += answer.best is not None
        return answer, seconds

    def _advance(self, seconds: float) -> None:
        self._now_s += seconds
        self._carried -= sum(made.alights for made in self._board.advance(self._now_s))


if __name__ == "__main__":
    main()
