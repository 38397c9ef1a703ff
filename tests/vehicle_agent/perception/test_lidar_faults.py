"""Which lidar is silent, unusable or moved reaches the status by its name."""

from vehicle_agent.guard.faults import fault_events
from vehicle_agent.perception.lidar_faults import (
    CONDITIONS_AGE_NS_MAX,
    DETAIL_MAX,
    NO_CONDITIONS,
    lidar_faults,
    newest_conditions,
)
from vehicle_agent.signals import Fault, LidarCondition, LidarConditions

S = 1_000_000_000


def conditions(*lidars: LidarCondition, stamp_ns: int = S) -> LidarConditions:
    return LidarConditions(stamp_ns, lidars)


def test_each_lidar_is_named_by_what_is_wrong_with_it() -> None:
    found = lidar_faults(
        conditions(
            LidarCondition("rear", "silent", False),
            LidarCondition("front_left", "moved"),
            LidarCondition("left", "silent", False),
        ),
        S,
    )
    assert found == (
        Fault("lidar_silent", "warning", S, "left, rear"),
        Fault("lidar_moved", "warning", S, "front_left"),
    )


def test_a_required_lidar_that_is_not_there_names_what_makes_the_vehicle_blind() -> None:
    found = lidar_faults(
        conditions(LidarCondition("roof", "unusable"), LidarCondition("rear", "silent", False)), S
    )
    assert {(fault.code, fault.detail) for fault in found} == {
        ("lidar_silent", "rear"), ("lidar_unusable", "roof"), ("lidar_blind", "roof"),
    }  # fmt: skip


def test_the_newest_word_counts_until_it_is_old() -> None:
    old = conditions(LidarCondition("roof", "moved"))
    well = conditions(stamp_ns=2 * S)
    assert newest_conditions(NO_CONDITIONS, (old,)) is old
    assert newest_conditions(well, (old,)) is well
    assert lidar_faults(well, 2 * S) == ()
    assert lidar_faults(old, S + CONDITIONS_AGE_NS_MAX) != ()
    assert lidar_faults(old, S + CONDITIONS_AGE_NS_MAX + 1) == ()


def test_many_long_names_fit_on_the_wire() -> None:
    many = conditions(*(LidarCondition(f"lidar_with_a_long_name_{k}", "silent", False) for k in range(40)))
    (fault,) = lidar_faults(many, S)
    assert len(fault.detail) <= DETAIL_MAX


def test_another_lidar_is_another_fault_and_the_first_one_is_cleared() -> None:
    one, both = (Fault("lidar_moved", "warning", S, name) for name in ("left", "left, right"))
    reported, events = fault_events((one,), (both,), "autonomous", 2 * S, 0)
    assert reported == (both,)
    assert [(event.fault.detail, event.cleared) for event in events] == [
        ("left, right", False),
        ("left", True),
    ]
