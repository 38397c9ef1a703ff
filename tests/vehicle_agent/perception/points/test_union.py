"""What a network found takes the clusters that lie in it; what it missed stays."""

import math

import msgspec
import numpy as np

from vehicle_agent.perception.points.union import SCORE_MIN, union
from vehicle_agent.signals import CYCLIST, OTHER, PEDESTRIAN, VEHICLE
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


def test_where_the_points_show_nobody_an_unsure_thing_without_a_kind_counts() -> None:
    unsure = seen((OTHER, 0.25, 4.0, 0.0, 0.4), (OTHER, 0.25, 9.0, 0.0, 0.4), (VEHICLE, 0.25, 4.0, 3.0, 4.5))
    found = union(seen(), unsure, np.array([True, False, True]))
    assert found.poses_base[:, :2].tolist() == [[4.0, 0.0]]
    under_a_cluster = seen((PEDESTRIAN, 0.8, 4.0, 0.0, 0.5))
    assert union(under_a_cluster, unsure, np.ones(3, np.bool_)).kinds.tolist() == [OTHER, PEDESTRIAN]


def test_an_unsure_network_changes_nothing() -> None:
    clusters = seen((PEDESTRIAN, 0.8, 10.0, 2.0, 0.5))
    found = union(clusters, seen((VEHICLE, SCORE_MIN - 0.01, 10.0, 2.0, 4.5)))
    assert found.kinds.tolist() == [PEDESTRIAN]


def test_without_clusters_or_without_network_the_other_is_all_there_is() -> None:
    some = seen((PEDESTRIAN, 0.8, 10.0, 2.0, 0.5))
    assert union(seen(), some).kinds.tolist() == [PEDESTRIAN]
    assert union(some, seen()).kinds.tolist() == [PEDESTRIAN]
    assert union(seen(), seen()).poses_base.shape == (0, 3)


def fitted(objects: SeenObjects, *, length_m: float = 4.5) -> SeenObjects:
    """The same objects, as boxes that their returns show."""
    sizes = objects.sizes_m.copy()
    sizes[:, 0] = length_m
    return msgspec.structs.replace(objects, sizes_m=sizes, is_fitted=np.ones(len(objects.kinds), np.bool_))


def test_a_car_stands_where_its_returns_are_and_looks_where_the_network_says() -> None:
    network = seen((VEHICLE, 0.8, 10.3, 2.2, 4.1))
    network.poses_base[0, 2] = 3.0
    network.velocities_base_mps[0] = 0.4, 0.0
    found = union(fitted(seen((VEHICLE, 1.0, 10.0, 2.0, 4.5))), network)
    assert found.kinds.tolist() == [VEHICLE]
    assert found.scores.tolist() == [0.8]
    assert found.poses_base[0, :2].tolist() == [10.0, 2.0]
    assert abs(math.remainder(found.poses_base[0, 2] - math.pi, 2.0 * math.pi)) < 1e-9
    assert found.sizes_m[0, 0] == 4.5
    assert found.fitted().tolist() == [True]
    assert np.isnan(found.velocities_base_mps).all()


def test_of_two_boxes_on_one_car_the_surer_one_is_it() -> None:
    network = seen((VEHICLE, 0.4, 10.5, 2.0, 4.1), (VEHICLE, 0.8, 10.2, 2.1, 4.2))
    found = union(fitted(seen((VEHICLE, 1.0, 10.0, 2.0, 4.5))), network)
    assert found.fitted().tolist() == [False, True]
    assert found.poses_base[:, 0].tolist() == [10.5, 10.0]


def test_who_comes_out_close_behind_a_parked_car_is_not_a_part_of_it() -> None:
    # The network's box of the car is half a metre off, towards the rider.
    clusters = seen((CYCLIST, 1.0, 12.5, 2.0, 1.4), (VEHICLE, 1.0, 10.0, 2.0, 4.5))
    is_fitted = np.array([False, True])
    found = union(
        msgspec.structs.replace(clusters, is_fitted=is_fitted), seen((VEHICLE, 0.8, 10.5, 2.0, 4.5))
    )
    assert sorted(found.kinds.tolist()) == sorted([CYCLIST, VEHICLE])


def test_a_person_beside_a_car_is_seen_and_a_mirror_is_not() -> None:
    network = seen((VEHICLE, 0.8, 10.0, 2.0, 4.5))
    beside = 2.0 + 0.5 * 1.5 + 0.15
    person = union(seen((PEDESTRIAN, 0.9, 10.0, beside, 0.5)), network)
    assert sorted(person.kinds.tolist()) == sorted([PEDESTRIAN, VEHICLE])
    assert union(seen((OTHER, 0.9, 10.0, beside, 0.2)), network).kinds.tolist() == [VEHICLE]
