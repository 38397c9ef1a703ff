"""Windows as the bound tightens them, and the instances that it refuses."""

from dataclasses import replace

import numpy as np
import pytest

from campusloop.studies.bound.events import TooManyEvents, event_graph
from campusloop.studies.bound.network import network_of
from campusloop.studies.instances.instance import InstanceBroken
from tests.campusloop.studies.bound.small_instances import a_ring


def test_windows_without_an_end_get_one_that_no_route_needs() -> None:
    ring = a_ring(4)
    endless = replace(ring, late=np.full_like(ring.late, np.inf), ride_max=np.inf, duration_max=np.inf)
    network = network_of(endless)
    assert np.isfinite(network.late).all()
    assert (network.late >= network.early + 40.0).all()


def test_a_ride_that_is_longer_than_allowed_is_named() -> None:
    with pytest.raises(InstanceBroken, match="node 1"):
        network_of(replace(a_ring(4), ride_max=16.9))


def test_waiting_with_somebody_aboard_counts_as_duty() -> None:
    ring = a_ring(4)
    early = ring.early.copy()
    early[5] = 90.0  # picked up by 45
    with pytest.raises(InstanceBroken, match="node 1"):
        network_of(replace(ring, early=early, ride_max=60.0, duration_max=60.0))


def test_numbers_too_large_to_be_exact_are_refused() -> None:
    ring = a_ring(4)
    with pytest.raises(InstanceBroken, match="exact below"):
        network_of(replace(ring, xy=1e5 * ring.xy))


def test_a_graph_that_outgrows_its_limit_is_refused() -> None:
    with pytest.raises(TooManyEvents, match="more than 20"):
        event_graph(network_of(a_ring(10)), 20)
