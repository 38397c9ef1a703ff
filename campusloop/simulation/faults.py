"""Faults of every kind at random moments, from the seed."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import msgspec

from campusloop.simulation.clocks import WallClock
from campusloop.simulation.fleet.vehicle import SimulatedVehicle
from campusloop.simulation.network import Network, PeopleTransport
from campusloop.simulation.observation import Observation
from campusloop.simulation.process.store import SimulatedDatabase, StoreFaults
from campusloop.simulation.timeline import Timeline
from contract.wire.messages import RiderAlighted, RiderBoarded, RiderNoShow


@dataclass(frozen=True, slots=True)
class Surroundings:
    """What faults are done to."""

    timeline: Timeline
    network: Network
    people: PeopleTransport
    database: SimulatedDatabase
    store: StoreFaults
    clock: WallClock
    vehicles: Mapping[str, SimulatedVehicle]
    observation: Observation
    crash_server: Callable[[str], None]


class FaultInjector:
    """`begin`; `end` takes back every fault that lasts."""

    def __init__(self, surroundings: Surroundings, kinds: tuple[str, ...]) -> None:
        """Raises KeyError for a kind that is not in KINDS."""
        self._s = surroundings
        self._kinds = {kind: KINDS[kind] for kind in kinds}
        self._is_over = False
        self.rngs = {kind: surroundings.timeline.rng(f"fault {kind}") for kind in kinds}

    def begin(self, after_s: float) -> None:
        for kind in self._kinds:
            self._s.timeline.after(after_s, lambda kind=kind: self._next(kind))  # type: ignore[misc]

    def end(self) -> None:
        self._is_over = True
        s = self._s
        s.database.free_disk()
        s.database.is_locked = False
        s.store.slow_s, s.store.ends_after, s.store.ends_before = 0.0, None, None
        s.people.lost_ratio = 0.0
        s.clock.ahead_s = 0.0
        s.observation.clock_leapt(0.0)
        for vehicle_id, vehicle in s.vehicles.items():
            path = s.network.path(vehicle_id)
            path.is_up, path.delay_s, path.repeat_ratio = True, 0.0, 0.0
            vehicle.disk.crash_pending = False
        s.observation.note("faults", "end")

    def _next(self, kind: str) -> None:
        per_h, _ = self._kinds[kind]
        wait_s = self.rngs[kind].expovariate(per_h / 3600.0)
        self._s.timeline.after(wait_s, lambda: self._strike(kind))

    def _strike(self, kind: str) -> None:
        if self._is_over:
            return
        _, strike = self._kinds[kind]
        strike(_Hand(kind, self._s, self.rngs[kind].uniform, self.rngs[kind].random, self))
        self._next(kind)

    def later(self, delay_s: float, action: Callable[[], None]) -> None:
        """Unless the faults have ended, and all is mended, by then."""
        self._s.timeline.after(delay_s, lambda: None if self._is_over else action())


@dataclass(frozen=True, slots=True)
class _Hand:
    """One strike: what it is done to, and its chance."""

    kind: str
    s: Surroundings
    uniform: Callable[[float, float], float]
    chance: Callable[[], float]
    injector: FaultInjector

    def vehicle(self) -> SimulatedVehicle:
        names = tuple(self.s.vehicles)
        return self.s.vehicles[names[int(self.chance() * len(names))]]

    def note(self, subject: str, what: str = "") -> None:
        self.s.observation.fault(self.kind, subject, what)

    def for_a_while(self, seconds: float, undo: Callable[[], None]) -> None:
        self.injector.later(seconds, undo)


# ---------------------------------------------------------------- wire


def _cut(hand: _Hand) -> None:
    vehicle_id = hand.vehicle().setup.vehicle_id
    hand.note(vehicle_id)
    hand.s.network.cut(vehicle_id)


def _half_close(hand: _Hand) -> None:
    vehicle_id = hand.vehicle().setup.vehicle_id
    hand.note(vehicle_id)
    hand.s.network.half_close(vehicle_id)


def _partition(hand: _Hand) -> None:
    vehicle_id = hand.vehicle().setup.vehicle_id
    path, seconds = hand.s.network.path(vehicle_id), hand.uniform(5.0, 240.0)
    hand.note(vehicle_id, f"{seconds:.0f} s")
    path.is_up = False
    hand.for_a_while(seconds, lambda: setattr(path, "is_up", True))


def _delay(hand: _Hand) -> None:
    vehicle_id = hand.vehicle().setup.vehicle_id
    path, seconds = hand.s.network.path(vehicle_id), hand.uniform(20.0, 200.0)
    path.delay_s = hand.uniform(0.3, 12.0)
    hand.note(vehicle_id, f"{path.delay_s:.1f} s for {seconds:.0f} s")
    hand.for_a_while(seconds, lambda: setattr(path, "delay_s", 0.0))


def _repeat(hand: _Hand) -> None:
    vehicle_id = hand.vehicle().setup.vehicle_id
    path, seconds = hand.s.network.path(vehicle_id), hand.uniform(20.0, 200.0)
    path.repeat_ratio = hand.uniform(0.05, 0.5)
    hand.note(vehicle_id, f"{path.repeat_ratio:.2f} for {seconds:.0f} s")
    hand.for_a_while(seconds, lambda: setattr(path, "repeat_ratio", 0.0))


def _lost_answers(hand: _Hand) -> None:
    people, seconds = hand.s.people, hand.uniform(30.0, 300.0)
    people.lost_ratio = hand.uniform(0.1, 0.6)
    hand.note("people", f"{people.lost_ratio:.2f} for {seconds:.0f} s")
    hand.for_a_while(seconds, lambda: setattr(people, "lost_ratio", 0.0))


# ---------------------------------------------------------------- server and store


def _server_crash(hand: _Hand) -> None:
    hand.note("server")
    hand.s.crash_server("crash")


def _server_crash_at_commit(hand: _Hand) -> None:
    commits = int(hand.uniform(0.0, 20.0))
    where = "ends_after" if hand.chance() < 0.5 else "ends_before"
    hand.note("server", f"{where} {commits} commits")
    setattr(hand.s.store, where, commits)


def _full_disk(hand: _Hand) -> None:
    seconds = hand.uniform(5.0, 90.0)
    hand.note("store", f"{seconds:.0f} s")
    hand.s.database.fill_disk()
    hand.for_a_while(seconds, hand.s.database.free_disk)


def _locked(hand: _Hand) -> None:
    seconds = hand.uniform(2.0, 60.0)
    hand.note("store", f"{seconds:.0f} s")
    hand.s.database.is_locked = True
    hand.for_a_while(seconds, lambda: setattr(hand.s.database, "is_locked", False))


def _slow_store(hand: _Hand) -> None:
    seconds, slow_s = hand.uniform(10.0, 90.0), hand.uniform(0.01, 0.3)
    hand.note("store", f"{slow_s:.2f} s a commit for {seconds:.0f} s")
    hand.s.store.slow_s = slow_s
    hand.for_a_while(seconds, lambda: setattr(hand.s.store, "slow_s", 0.0))


def _server_clock(hand: _Hand) -> None:
    ahead_s = hand.uniform(1.0, 30.0) if hand.chance() < 0.5 else hand.uniform(60.0, 3600.0)
    ahead_s = -ahead_s if hand.chance() < 0.5 else ahead_s
    seconds = hand.uniform(30.0, 600.0)
    hand.note("server", f"{ahead_s:+.0f} s for {seconds:.0f} s")
    _set_clock(hand.s, ahead_s)
    hand.for_a_while(seconds, lambda: _set_clock(hand.s, 0.0))


def _set_clock(s: Surroundings, ahead_s: float) -> None:
    s.clock.ahead_s = ahead_s
    s.observation.clock_leapt(ahead_s)


# ---------------------------------------------------------------- vehicles


def _vehicle_crash(hand: _Hand) -> None:
    vehicle = hand.vehicle()
    hand.note(vehicle.setup.vehicle_id)
    vehicle.crash()


def _torn_write(hand: _Hand) -> None:
    vehicle = hand.vehicle()
    hand.note(vehicle.setup.vehicle_id)
    vehicle.disk.crash_pending = True


def _freeze(hand: _Hand) -> None:
    vehicle, seconds = hand.vehicle(), hand.uniform(2.0, 150.0)
    hand.note(vehicle.setup.vehicle_id, f"{seconds:.0f} s")
    vehicle.freeze(seconds)


def _poison(hand: _Hand) -> None:
    """Numbers that no vehicle can have, as no encoder of ours would write them."""
    vehicle = hand.vehicle()
    hand.note(vehicle.setup.vehicle_id)
    if vehicle.link is not None and vehicle.is_running:
        vehicle.link.send_raw(_POISONS[int(hand.chance() * len(_POISONS))])


def _forgery(hand: _Hand) -> None:
    """Events about a ride of another vehicle."""
    vehicle, other = hand.vehicle(), hand.vehicle()
    memory = other.memory
    order = None if memory is None else memory.order
    if vehicle is other or order is None:
        return
    rides = [rider.ride_id for visit in order.visits for rider in (*visit.board, *visit.alight)]
    if rides:
        ride_id = rides[int(hand.chance() * len(rides))]
        hand.note(vehicle.setup.vehicle_id, f"about {ride_id}")
        vehicle.forged += [
            RiderBoarded(ride_id, "code"),
            RiderNoShow(ride_id),
            RiderAlighted(ride_id, "code"),
        ]


_POISONS = (
    msgspec.json.encode({"type": "status", "epoch": 2**62}),
    b'{"type":"status","epoch":1,"stamp_ns":1e400}',
    b'{"type":"event","epoch":-1,"boot_id":"x","sequence":9223372036854775808,"stamp_ns":0,"body":{}}',
    b'{"type":"nonsense"}',
    b"\xff\xfe not JSON",
)

# By name: how often in an hour, on the whole campus, and what it does.
KINDS: Mapping[str, tuple[float, Callable[[_Hand], None]]] = {
    "cut": (60.0, _cut),
    "half-close": (30.0, _half_close),
    "partition": (12.0, _partition),
    "delay": (12.0, _delay),
    "repeat": (12.0, _repeat),
    "lost-answers": (4.0, _lost_answers),
    "server-crash": (3.0, _server_crash),
    "crash-at-commit": (6.0, _server_crash_at_commit),
    "full-disk": (2.0, _full_disk),
    "locked": (2.0, _locked),
    "slow-store": (4.0, _slow_store),
    "server-clock": (2.0, _server_clock),
    "vehicle-crash": (8.0, _vehicle_crash),
    "torn-write": (12.0, _torn_write),
    "freeze": (10.0, _freeze),
    "poison": (4.0, _poison),
    "forgery": (10.0, _forgery),
}
