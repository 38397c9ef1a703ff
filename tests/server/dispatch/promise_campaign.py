"""Days of random events in one schedule, driven as planned: each promise and what came of it.

python -m tests.server.dispatch.promise_campaign --events 1000000 --seed 1
"""

import argparse
import sys
from dataclasses import dataclass, field

import numpy as np

from server.dispatch.answer import PromiseRules, answer_all
from server.dispatch.engine.plan import ABSENT
from server.dispatch.improve import CoolingSchedule, improve
from server.dispatch.problem import Call, Chain, Problem, Request, VehicleState
from server.dispatch.schedule.chains import insert_chain
from server.dispatch.schedule.schedule import CompletedCall, Schedule
from server.dispatch.solve import without_deadline

_TERMS = PromiseRules(60.0, 300.0, 300.0, 0.5, 3600.0)
_STOPS = 12
_DWELL_S = 15.0
# A schedule for so many events; then another day begins.
_DAY_EVENTS = 400
_TOLERANCE_S = 1e-3


@dataclass(slots=True)
class Campaign:
    """What happened. broken: a line for every promise that was not kept."""

    events: int = 0
    taken: int = 0
    refused: int = 0
    cancelled: int = 0
    improved: int = 0
    departures: int = 0
    broken: list[str] = field(default_factory=list)


def run_campaign(seed: int, events: int) -> Campaign:
    """So many events: bookings, cancellations, improvements, departures, vehicles that stop accepting."""
    campaign = Campaign()
    day = 0
    while campaign.events < events:
        _Day(np.random.default_rng([seed, day]), campaign).play(min(_DAY_EVENTS, events - campaign.events))
        day += 1
    return campaign


class _Day:
    def __init__(self, rng: np.random.Generator, campaign: Campaign) -> None:
        self._rng, self._campaign = rng, campaign
        xy = rng.uniform(0.0, 900.0, (_STOPS, 2))
        self._times = np.linalg.norm(xy[:, None] - xy[None, :], axis=2) / 3.0
        self._seats = int(rng.integers(2, 7))
        fleet = tuple(
            VehicleState(f"v{k}", self._times[int(rng.integers(_STOPS))], 0.0, self._seats, 1)
            for k in range(int(rng.integers(1, 5)))
        )
        chains = tuple(self._chain(k) for k in range(int(rng.integers(0, 3))))
        problem = Problem(fleet, {}, self._times, open_chains=chains, dwell_s=_DWELL_S)
        departure_slack = float(rng.choice([0.0, 0.5, 1.0]))
        self._schedule = Schedule(problem, spare=_DAY_EVENTS, departure_slack=departure_slack)
        campaign.departures += sum(insert_chain(self._schedule, chain) for chain in chains)
        self._now_s = 0.0
        self._promises: dict[str, tuple[float, float, float]] = {}
        self._limits: dict[str, float] = {}
        self._picked: dict[str, float] = {}
        self._inside = dict.fromkeys(self._schedule.vehicle_ids, 0)
        self._party: dict[str, int] = {}

    def play(self, events: int) -> None:
        what = (self._book, self._book, self._book, self._cancel, self._improve, self._toggle)
        for number in range(events):
            self._go_on(float(self._rng.exponential(60.0)))
            what[int(self._rng.integers(len(what)))](number)
            self._campaign.events += 1
        self._go_on(1e5)
        for name in self._promises:
            self._campaign.broken.append(f"{name} was promised a ride and never had it")

    def _chain(self, k: int) -> Chain:
        begins_s = float(self._rng.uniform(600.0, 6000.0))
        places = self._rng.choice(_STOPS, 3, replace=False)
        calls, at_s = [], begins_s
        for before, place in zip([int(places[0]), *places[:-1]], places, strict=True):
            at_s += float(self._times[int(before), int(place)]) + 2.0 * _DWELL_S
            calls.append(Call(int(place), (), (), _DWELL_S, at_s, at_s + 120.0, True, f"trip{k}"))
        return Chain(f"trip{k}", tuple(calls))

    def _book(self, number: int) -> None:
        name = f"r{number}"
        pickup, dropoff = (int(place) for place in self._rng.choice(_STOPS, 2, replace=False))
        from_s = self._now_s + float(self._rng.choice([0.0, self._rng.uniform(0.0, 3600.0)]))
        party = int(self._rng.integers(1, 5))
        direct_s = float(self._times[pickup, dropoff])
        longest_s = max(2.0 * direct_s, direct_s + 300.0)
        wheelchairs = int(self._rng.random() < 0.1)
        self._schedule.add(
            Request(name, pickup, dropoff, party, wheelchairs, from_s, from_s + 900.0, np.inf, longest_s)
        )
        (answer,) = answer_all(self._schedule, [name], _TERMS)
        if answer.windows is None:
            self._campaign.refused += 1
            return
        self._campaign.taken += 1
        self._promises[name], self._limits[name], self._party[name] = answer.windows, longest_s, party

    def _cancel(self, _: int) -> None:
        waiting = [name for name in self._promises if self._schedule.plan.movable[self._schedule.rows[name]]]
        if waiting:
            name = waiting[int(self._rng.integers(len(waiting)))]
            self._schedule.remove(name)
            del self._promises[name]
            self._campaign.cancelled += 1

    def _improve(self, number: int) -> None:
        self._campaign.improved += improve(
            self._schedule, CoolingSchedule(2, 20), number, 2, without_deadline
        )
        lost = [
            name
            for name in self._promises
            if self._schedule.plan.vehicle_of[self._schedule.rows[name]] == ABSENT
        ]
        self._campaign.broken += [f"{name} was dropped by an improvement" for name in lost]

    def _toggle(self, _: int) -> None:
        """A vehicle is told to take nobody new, or is free again; what it has it keeps."""
        v = int(self._rng.integers(len(self._schedule.vehicle_ids)))
        self._schedule.accepts[v] = not self._schedule.accepts[v]

    def _go_on(self, seconds: float) -> None:
        self._now_s += seconds
        for made in self._schedule.advance(self._now_s):
            self._check(made)

    def _check(self, made: CompletedCall) -> None:
        name, late_s = made.request_id, _TOLERANCE_S
        opens_s, closes_s, by_s = self._promises[name]
        self._inside[made.vehicle_id] += (-1 if made.alights else 1) * self._party[name]
        if self._inside[made.vehicle_id] > self._seats:
            self._campaign.broken.append(f"{made.vehicle_id} carries too many at {made.at_s}")
        if not made.alights:
            self._picked[name] = made.at_s
            if not opens_s - late_s <= made.at_s <= closes_s + late_s:
                self._campaign.broken.append(f"{name} picked up at {made.at_s}, not in {opens_s}..{closes_s}")
            return
        rode_s = made.at_s - self._picked[name] - _DWELL_S
        if made.at_s > by_s + late_s or rode_s > self._limits[name] + late_s:
            self._campaign.broken.append(f"{name} rode {rode_s} s until {made.at_s}, not by {by_s}")
        del self._promises[name]


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--events", type=int, default=1_000_000)
    parser.add_argument("--seed", type=int, default=1)
    args = parser.parse_args()
    campaign = run_campaign(args.seed, args.events)
    print(
        f"seed {args.seed}: {campaign.events} events, {campaign.taken} rides taken,",
        f"{campaign.refused} refused, {campaign.cancelled} cancelled,",
        f"{campaign.departures} departures, {len(campaign.broken)} broken",
    )
    if campaign.broken:
        sys.exit("\n".join(campaign.broken[:20]))


if __name__ == "__main__":
    main()
