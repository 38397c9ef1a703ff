"""Small dial-a-ride instances, and their optima by brute force."""

import itertools
import math
from collections.abc import Iterator

import numpy as np
from hypothesis import strategies as st

from campusloop.studies.instances.instance import Instance

_SLACK = 1e-6


@st.composite
def instances(draw: st.DrawFn, wanted_max: int = 4) -> Instance:
    """A few requests on a small grid; half of the windows are wide."""
    wanted = draw(st.integers(1, wanted_max))
    xy = [(0, 0)] + [(draw(st.integers(-8, 8)), draw(st.integers(-8, 8))) for _ in range(2 * wanted)]
    loads = [draw(st.integers(1, 2)) for _ in range(wanted)]
    early, late = [0.0], [200.0]
    for _ in range(2 * wanted):
        opens = draw(st.integers(0, 60))
        early.append(float(opens))
        late.append(float(opens + draw(st.sampled_from([5, 15, 40, 140]))))
    service = [0.0] + [float(draw(st.integers(0, 3)))] * (2 * wanted)
    return Instance(
        name="drawn",
        vehicles=draw(st.integers(1, 3)),
        capacity=draw(st.integers(2, 4)),
        duration_max=float(draw(st.sampled_from([50, 90, 400]))),
        ride_max=float(draw(st.sampled_from([12, 25, 60]))),
        nodes=np.arange(2 * wanted + 1),
        xy=np.array(xy, np.float64),
        service=np.array(service),
        load=np.array([0, *loads, *(-load for load in loads)]),
        early=np.array(early),
        late=np.array(late),
        pairs=np.array([(i + 1, wanted + i + 1) for i in range(wanted)]),
    )


def seeded_instance(seed: int) -> Instance:
    """Three to five requests; fleet, places, ride and route times from ample to far too small."""
    rng = np.random.default_rng(seed)
    wanted = int(rng.integers(3, 6))
    rows = 2 * wanted + 1
    xy = rng.uniform(-1.0, 1.0, (rows, 2)) * rng.choice([5.0, 10.0])
    if rng.random() < 0.3:
        xy = 3.0 * np.rint(xy / 3.0)  # some places coincide
    horizon = float(rng.choice([80.0, 160.0]))
    early, late = np.zeros(rows), np.full(rows, horizon + 60.0)
    for request in range(wanted):
        node = 1 + request + (wanted if rng.random() < 0.5 else 0)
        early[node] = rng.uniform(10.0, horizon)
        late[node] = early[node] + rng.choice([2.0, 10.0, 15.0, 40.0])
    load = rng.integers(1, 4, wanted)
    return Instance(
        name=f"seed {seed}",
        vehicles=int(rng.integers(1, wanted + 1)),
        capacity=int(rng.integers(3, 7)),
        duration_max=float(rng.choice([40, 70, 120, 500])),
        ride_max=float(rng.choice([10, 20, 30, 50])),
        nodes=np.arange(rows),
        xy=xy,
        service=np.concatenate([[0.0], np.full(rows - 1, float(rng.integers(0, 4)))]),
        load=np.concatenate([[0], load, -load]),
        early=early,
        late=late,
        pairs=np.column_stack([np.arange(1, wanted + 1), np.arange(wanted + 1, rows)]),
    )


def cost_of(instance: Instance, route: tuple[int, ...]) -> float:
    """Distance from the depot through the nodes and back."""
    return sum(math.dist(instance.xy[a], instance.xy[b]) for a, b in itertools.pairwise((0, *route, 0)))


def is_feasible(instance: Instance, route: tuple[int, ...], *, whole: bool = True) -> bool:
    """Do times exist? Difference constraints by relaxation; a part of a route has no way back yet."""
    stops = (0, *route, 0) if whole else (0, *route)
    place = {node: k for k, node in enumerate(route, start=1)}
    aboard = np.cumsum(instance.load[list(route)])
    if aboard.max() > instance.capacity:
        return False
    edges = []  # time[b] >= time[a] + weight
    for a, (here, there) in enumerate(itertools.pairwise(stops)):
        service = instance.service[here] if a else 0.0
        edges.append((a, a + 1, service + math.dist(instance.xy[here], instance.xy[there])))
    for up, down in instance.pairs:
        if up in place and down in place:
            edges.append((place[down], place[up], -instance.service[up] - instance.ride_max))
    if whole:
        edges.append((len(stops) - 1, 0, -instance.duration_max))
    time = [float(instance.early[node]) for node in stops]
    for _ in range(len(stops) + 2):
        moved = False
        for a, b, weight in edges:
            if time[a] + weight > time[b] + 1e-12:
                time[b] = time[a] + weight
                moved = True
        if not moved:
            break
    else:
        if moved:
            return False
    return all(t <= instance.late[node] + _SLACK for t, node in zip(time, stops, strict=True))


def all_routes(instance: Instance) -> Iterator[tuple[int, ...]]:
    """Every feasible route."""
    down_of = {int(up): int(down) for up, down in instance.pairs}

    def grow(route: tuple[int, ...], aboard: frozenset[int]) -> Iterator[tuple[int, ...]]:
        if route and not is_feasible(instance, route, whole=False):
            return
        if route and not aboard and is_feasible(instance, route):
            yield route
        for up, down in down_of.items():
            if up in aboard:
                yield from grow((*route, down), aboard - {up})
            elif up not in route:
                yield from grow((*route, up), aboard | {up})

    yield from grow((), frozenset())


def optimum(instance: Instance) -> float:
    """The cost of the best plan, inf when there is none: dynamic program over sets of requests."""
    bit = {int(up): 1 << k for k, (up, _) in enumerate(instance.pairs)}
    cheapest: dict[int, float] = {}
    for route in all_routes(instance):
        served = sum(bit.get(node, 0) for node in route)
        cheapest[served] = min(cheapest.get(served, math.inf), cost_of(instance, route))
    everybody = (1 << len(instance.pairs)) - 1
    best = {0: 0.0}
    for _ in range(instance.vehicles):
        grown = dict(best)
        for done, cost in best.items():
            for served, price in cheapest.items():
                if not done & served:
                    grown[done | served] = min(grown.get(done | served, math.inf), cost + price)
        best = grown
    return best.get(everybody, math.inf)


def a_ring(wanted: int) -> Instance:
    """Requests that cross a ring, all at the same hour; a vehicle cannot take everybody."""
    angle = np.arange(wanted) * 2.0 * math.pi / wanted
    ring = 10.0 * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return Instance(
        name="ring",
        vehicles=wanted,
        capacity=3,
        duration_max=200.0,
        ride_max=30.0,
        nodes=np.arange(2 * wanted + 1),
        xy=np.concatenate([[[0.0, 0.0]], ring, -0.7 * ring]),
        service=np.zeros(2 * wanted + 1),
        load=np.array([0] + [1] * wanted + [-1] * wanted),
        early=np.concatenate([[0.0], np.full(wanted, 20.0), np.full(wanted, 20.0)]),
        late=np.concatenate([[300.0], np.full(wanted, 45.0), np.full(wanted, 100.0)]),
        pairs=np.array([(i + 1, wanted + i + 1) for i in range(wanted)]),
    )
