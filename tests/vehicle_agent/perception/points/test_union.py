"""What a network found takes the clusters that lie in it; what it missed stays."""

import numpy as np

from vehicle_agent.perception.points.union import SCORE_MIN, union
from vehicle_agent.signals import OTHER, PEDESTRIAN, VEHICLE
from vehicle_agent.signals.objects import SeenObjects


def seen(*rows: tuple[int, float, float, float, float]) -> SeenObjects:
    """Rows of kind, score, x, y, length; a third as wide."""
    table = np.array(rows, dtype=np.float64).reshape(-1, 5)
    poses = np.column_stack((table[:, 2:4], np.zeros(len(table))))
    sizes = np.column_stack((table[:, 4], table[:, 4] / 3.0, np.full(len(table), 1.7)))
    velocities = np.full((len(table), 2), np.nan)
    return SeenObjects(7, table[:, 0].astype(np.int64), table[:, 1], poses, sizes, velocities)


def test_the_parts_of_a_car_are_one_car() -> None:
    clusters = seen((OTHER, 1.0, 8.2, 2.1, 0.6), (PEDESTRIAN, 0.8, 11.4, 1.9, 0.5))
    network = seen((VEHICLE, 0.9, 10.0, 2.0, 4.5))
    found = union(clusters, network)
    assert found.kinds.tolist() == [VEHICLE]
    assert found.stamp_ns == 7


def test_who_is_no_one_the_network_knows_stays_seen() -> None:
    clusters = seen((OTHER, 1.0, 8.0, -3.0, 0.6), (PEDESTRIAN, 0.8, 11.4, 6.0, 0.5))
    found = union(clusters, seen((VEHICLE, 0.9, 10.0, 2.0, 4.5)))
    assert sorted(found.kinds.tolist()) == sorted([VEHICLE, OTHER, PEDESTRIAN])


def test_what_a_finder_has_no_kind_for_gives_way_to_a_cluster_and_stays_where_there_is_none() -> None:
    clusters = seen((PEDESTRIAN, 0.8, 10.0, 2.0, 0.5))
    found = union(clusters, seen((OTHER, 0.5, 10.1, 2.1, 0.4), (OTHER, 0.5, 4.0, 0.0, 0.4)))
    assert sorted(found.kinds.tolist()) == sorted([PEDESTRIAN, OTHER])
    assert found.poses_base[found.kinds == OTHER, 0].tolist() == [4.0]


def test_an_unsure_network_changes_nothing() -> None:
    clusters = seen((PEDESTRIAN, 0.8, 10.0, 2.0, 0.5))
    found = union(clusters, seen((VEHICLE, SCORE_MIN - 0.01, 10.0, 2.0, 4.5)))
    assert found.kinds.tolist() == [PEDESTRIAN]


def test_without_clusters_or_without_network_the_other_is_all_there_is() -> None:
    some = seen((PEDESTRIAN, 0.8, 10.0, 2.0, 0.5))
    assert union(seen(), some).kinds.tolist() == [PEDESTRIAN]
    assert union(some, seen()).kinds.tolist() == [PEDESTRIAN]
    assert union(seen(), seen()).poses_base.shape == (0, 3)
