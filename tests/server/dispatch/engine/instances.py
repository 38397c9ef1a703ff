"""Small instances for the engine's tests."""

import numpy as np

from campusloop.studies.instances.instance import Instance, checked


def small_instance(seed: int, requests: int, vehicles: int = 2, ride_max: float = 25.0) -> Instance:
    """Random points within 10 of the depot, half of the requests with a window at the drop-off."""
    rng = np.random.default_rng(seed)
    n = 2 * requests + 1
    early, late = np.zeros(n), np.full(n, 240.0)
    for r in range(requests):
        node = 1 + r + (requests if r % 2 else 0)
        early[node] = rng.uniform(30.0, 150.0)
        late[node] = early[node] + 15.0
    load = rng.integers(1, 3, requests)
    return checked(
        Instance(
            name=f"small-{seed}",
            vehicles=vehicles,
            capacity=3,
            duration_max=200.0,
            ride_max=ride_max,
            nodes=np.arange(n),
            xy=np.vstack([np.zeros(2), rng.uniform(-10.0, 10.0, (n - 1, 2))]),
            service=np.concatenate([[0.0], np.full(n - 1, 2.0)]),
            load=np.concatenate([[0], load, -load]),
            early=early,
            late=late,
            pairs=np.column_stack([np.arange(1, requests + 1), np.arange(requests + 1, n)]),
        )
    )
