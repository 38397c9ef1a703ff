"""The room believes scans that fit, slows down while they disagree, and is right again by itself."""

import math

import numpy as np
import pytest

from contract.geometry import Pose2
from contract.roads.model import Origin
from contract.roads.projection import unproject
from vehicle_agent.localization.gnss_ins import GnssInsLocalization
from vehicle_agent.localization.scan_map.fusion import ScanMapLocalization, ScanMapState
from vehicle_agent.signals import (
    Ego,
    GnssFix,
    ImuSample,
    Navigation,
    PoseHint,
    ScanPose,
    ScanUnplaced,
    VehicleMotion,
)

ORIGIN = Origin(31.0, 121.0)
ROOM = ScanMapLocalization(GnssInsLocalization(ORIGIN))
STEP_NS = 20_000_000
SPEED_MPS = 2.0
SLOW_FROM_M = 0.3


class Ride:
    """A vehicle that drives east at 2 m/s; its wheels say 3 % too much."""

    def __init__(self, speed_mps: float = SPEED_MPS) -> None:
        self.speed_mps = speed_mps
        self._told: list[Navigation] = []
        self.state: ScanMapState = ROOM.initial()
        self.ticks = 0
        self.ego: Ego | None = None

    @property
    def x_m(self) -> float:
        return self.speed_mps * 0.02 * self.ticks

    def told(self, item: Navigation) -> None:
        """It comes with the next tick."""
        self._told.append(item)

    def drive(
        self,
        seconds: float,
        gnss: bool = False,
        scans: bool = False,
        off_m: float = 0.0,
        agreement: float = 0.9,
        through: float = 0.02,
    ) -> Ego:
        for _ in range(round(50.0 * seconds)):
            self.ticks += 1
            now_ns = STEP_NS * self.ticks
            items: list[Navigation] = [ImuSample(now_ns, 0.0, 0.0), *self._told]
            self._told = []
            if gnss:
                latitude, longitude = unproject(ORIGIN, self.x_m, 0.0)
                items.append(GnssFix(now_ns, latitude, longitude, 0.0, self.speed_mps, 0.0, 0.02, 0.005))
            if scans and self.ticks % 5 == 0:
                pose = Pose2(self.x_m - self.speed_mps * 0.1 + off_m, 0.0, 0.0)
                covariance = np.diag([0.02**2, 0.02**2, 0.002**2])
                items.append(ScanPose(now_ns - 5 * STEP_NS, pose, covariance, agreement, 400, False, through))
            motion = VehicleMotion(now_ns, 1.03 * self.speed_mps, 0.0, 0.0, 0.0, True, False, True, 1.0)
            self.ego, self.state = ROOM.step(self.state, motion, tuple(items), now_ns)
        assert self.ego is not None
        return self.ego

    def error_m(self) -> float:
        assert self.ego is not None
        return math.hypot(self.ego.pose_map.x_m - self.x_m, self.ego.pose_map.y_m)


def started() -> Ride:
    ride = Ride()
    ride.drive(20.0, gnss=True)
    return ride


def test_late_scans_hold_the_pose_through_a_long_outage() -> None:
    ride = started()
    ego = ride.drive(200.0, scans=True)
    assert ride.error_m() < 0.1
    assert ego.valid
    assert ego.position_std_m < SLOW_FROM_M
    alone = started()
    assert not alone.drive(200.0).valid


def test_what_is_stated_does_not_fall_below_the_maps_own_error() -> None:
    ride = started()
    ego = ride.drive(60.0, scans=True)
    assert ego.position_std_m > 0.5 * ROOM.map_std_m


def test_one_scan_elsewhere_does_not_move_the_pose() -> None:
    ride = started()
    ride.drive(10.0, scans=True)
    ride.drive(0.5, scans=True, off_m=5.0)
    assert ride.error_m() < 0.3


def test_scans_that_disagree_slow_the_vehicle_down_and_it_clears_by_itself() -> None:
    ride = started()
    ride.drive(10.0, scans=True)
    ego = ride.drive(3.0, scans=True, agreement=0.2, through=0.2)
    assert ego.valid
    assert ego.position_std_m > SLOW_FROM_M
    assert [(fault.code, fault.severity) for fault in ego.faults] == [("pose_poor", "warning")]
    ego = ride.drive(6.0, scans=True)
    assert ego.position_std_m < SLOW_FROM_M
    assert ego.faults == ()


def test_trucks_that_hide_half_of_the_map_are_no_reason_to_be_slow() -> None:
    ride = started()
    ride.drive(10.0, scans=True)
    ego = ride.drive(60.0, scans=True, agreement=0.35, through=0.04)
    assert ego.faults == ()
    assert ride.error_m() < 0.1


def test_a_wrong_pose_is_called_lost_within_two_seconds() -> None:
    ride = started()
    ride.drive(10.0, scans=True)
    ego = ride.drive(2.0, scans=True, agreement=0.1, through=0.15)
    assert ego.position_std_m > SLOW_FROM_M


def test_a_world_that_changed_bit_by_bit_is_what_is_expected_next() -> None:
    """The same scan after a good map is a reason to doubt, and after a changed world it is none."""
    ride = started()
    ride.drive(10.0, scans=True)
    suddenly = ride.drive(4.0, scans=True, agreement=0.36, through=0.14)
    assert suddenly.faults != ()
    slowly = started()
    for agreement in (0.8, 0.7, 0.6, 0.55, 0.5):
        slowly.drive(10.0, scans=True, agreement=agreement)
    assert slowly.drive(4.0, scans=True, agreement=0.36, through=0.14).faults == ()


def test_with_gnss_a_changed_world_slows_nothing_down() -> None:
    ride = started()
    ego = ride.drive(5.0, gnss=True, scans=True, agreement=0.2, through=0.2)
    assert ego.position_std_m < SLOW_FROM_M
    assert ride.error_m() < 0.1


@pytest.mark.parametrize("shift_m", [2.0, 8.0])
def test_a_kidnapped_pose_is_set_right_and_told(shift_m: float) -> None:
    ride = started()
    ride.drive(10.0, scans=True)
    ride.state = ROOM.hinted(ride.state, Pose2(ride.x_m + shift_m, 0.0, 0.0), 0.05, 0.01)
    codes = set()
    for _ in range(20):
        ego = ride.drive(0.2, scans=True)
        codes |= {fault.code for fault in ego.faults}
    assert "pose_jump" in codes
    assert ride.error_m() < 0.15


def test_a_scan_that_is_not_finite_is_dropped() -> None:
    ride = started()
    ride.drive(5.0, scans=True)
    ride.drive(2.0, scans=True, off_m=math.nan)
    assert ride.error_m() < 0.3
    assert np.isfinite(ride.state.covariance).all()


def test_a_vehicle_that_stays_in_doubt_stands_and_a_place_found_again_is_told() -> None:
    ride = started()
    ride.drive(10.0, scans=True)
    assert ride.drive(3.0, scans=True, agreement=0.2).phase == "doubtful"
    ego = ride.drive(8.0, scans=True, agreement=0.2)
    assert ego.phase == "lost"
    assert not ego.valid
    assert [(fault.code, fault.severity) for fault in ego.faults] == [("pose_poor", "stop")]
    phases = [ride.drive(0.1, scans=True).phase for _ in range(60)]
    assert "recovered" in phases
    assert phases[-1] == "tracking"


def test_a_worker_without_a_word_is_told_and_gnss_goes_on() -> None:
    ride = started()
    ego = ride.drive(3.5, gnss=True)
    assert ego.phase == "gnss_only"
    assert [(fault.code, fault.severity) for fault in ego.faults] == [("localization_silent", "warning")]
    assert ego.valid
    ego = ride.drive(2.0, gnss=True, scans=True)
    assert ego.phase == "tracking"
    assert ego.faults == ()


def test_where_the_map_has_nothing_gnss_goes_on_without_a_fault() -> None:
    ride = started()
    for _ in range(40):
        ride.told(ScanUnplaced(STEP_NS * ride.ticks, "no_map"))
        ego = ride.drive(0.1, gnss=True)
    assert ego.phase == "gnss_only"
    assert ego.faults == ()


def test_a_hint_places_a_vehicle_that_never_had_a_fix() -> None:
    ride = Ride(speed_mps=0.0)
    assert ride.drive(1.0).phase == "waiting"
    ride.told(PoseHint("hint-1", Pose2(1.5, -1.0, 0.1)))
    assert ride.drive(0.5).phase == "doubtful"
    ego = ride.drive(3.0, scans=True)
    assert ego.phase in ("recovered", "tracking")
    assert ride.error_m() < 0.1
    assert ego.valid
    # A repeat of the same hint changes nothing.
    ride.told(PoseHint("hint-1", Pose2(50.0, 0.0, 0.0)))
    ride.drive(0.1)
    assert ride.error_m() < 0.1


def test_a_moving_vehicle_takes_no_hint() -> None:
    ride = started()
    ride.told(PoseHint("hint-1", Pose2(500.0, 0.0, 0.0)))
    ride.drive(0.1, gnss=True)
    assert ride.error_m() < 0.3


def test_a_vehicle_without_fix_and_hint_starts_where_scans_in_a_row_say() -> None:
    room = ScanMapLocalization(GnssInsLocalization(ORIGIN), starts_alone=True)
    state, covariance = room.initial(), np.diag([0.02**2, 0.02**2, 0.002**2])
    for tick in range(1, 120):
        now_ns = STEP_NS * tick
        items: list[Navigation] = [ImuSample(now_ns, 0.0, 0.0)]
        if tick % 5 == 0 and tick > 20:
            # One scan says another place: those before it do not count.
            place = Pose2(90.0, 0.0, 0.0) if tick == 40 else Pose2(50.0, 7.0, 1.0)
            items.append(ScanPose(now_ns - 5 * STEP_NS, place, covariance, 0.9, 400, True))
        motion = VehicleMotion(now_ns, 0.0, 0.0, 0.0, 0.0, True, False, True, 1.0)
        ego, state = room.step(state, motion, tuple(items), now_ns)
        (job,) = room.jobs(state)
        assert job.is_unknown == (tick < 80), "eight scans after the one that disagreed"
    assert math.hypot(ego.pose_map.x_m - 50.0, ego.pose_map.y_m - 7.0) < 0.02
    assert ego.valid
    assert not ROOM.jobs(ROOM.initial()), "a worker that searches no whole map is not asked"


def test_the_place_of_a_lost_vehicle_is_proven_by_gnss_and_scans() -> None:
    ride = started()
    ride.drive(10.0, scans=True)
    # Odometry is good; the scans of another place say that it is not.
    while ride.drive(0.5, scans=True, agreement=0.1, through=0.4).phase != "lost":
        pass
    assert ride.ego is not None
    assert ride.ego.proven_ns == 0
    for _ in range(20):
        ego = ride.drive(0.5, scans=True)
    assert (ego.phase, ego.proven_ns) == ("tracking", 0), "scans alone prove nothing"
    ego = ride.drive(6.0, scans=True, gnss=True)
    assert ego.proven_ns > 0
