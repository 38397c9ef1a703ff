"""The numbers by which the fleet is run; every use case gets them."""

from dataclasses import dataclass, field

from server.domain.service.timetable import ServiceHours


@dataclass(frozen=True, slots=True)
class FleetRules:
    """Seconds, metres and metres per second.

    speed_cap_mps         the top speed of a shuttle; travel times are planned with it
    travel_time_factor    planned over free-flow travel time: people in the way, waiting for sections
    dwell_s               doors stay open at least so long when riders board or alight
    wait_s_max            a booking is refused if no vehicle can come within this time after `earliest`
    detour_ratio_max, detour_s_min  a ride may take max(ratio x direct, direct + min) at most
    pickup_early_s, pickup_slack_s  the promised pickup window around the planned pickup, which ends later
    pickup_slack_ratio    by this share of the time until then: distant times are less certain
    uncertain_s_max       the time beyond it adds nothing: shuttles have stood meanwhile
    arrival_slack_s, arrival_slack_ratio  the promised latest arrival after the planned one, the second
                          as a share of the planned time on board
    promise_lapse_s       if the plan misses a promise by more, the party gets a new one
    promise_notice_s      a renewed promise becomes earlier by no less, and no sooner than so long after
    promise_reserve_s, promise_reserve_ratio  of a promise's slack, later riders must leave this much, and
                          this share of the time until then, as a reserve for the drive
    walk_m_max, walk_mps  other stops are offered within this distance (straight), walked at this speed
    later_s_max           how much later than requested an alternative may be
    departure_tolerance_s a vehicle that would leave a timetable call later than this does not get it
    departure_lead_s      how long before its first call a departure gets its shuttle
    grant_ahead_m         sections are granted up to this distance ahead of a shuttle
    braking_mps2, reaction_s  a new visit lies at least a stopping distance ahead of a moving shuttle
    reassign_after_s      other vehicles get the waiting rides of a vehicle that is unavailable for so long
    order_stops           an order has so many stops, then a resting place: short routes are safe sooner
    held_back_s           a resting shuttle leaves so much earlier than a promised pickup requires
    departure_early_s     the same for a timetable call, whose time cannot be changed
    battery_reserve_ratio no plan takes a battery below it; a shuttle that falls below gets no more rides
    battery_charge_below_ratio, battery_accept_ratio, battery_full_ratio  an idle shuttle below the first
                          goes to charge, is given rides again from the second on, and charges to the third
    battery_per_drive_s   of a battery, for each second of planned driving: 2.5 kW of 8.6 kWh
    battery_per_charge_s  of a battery, for each second at a charger: 6.5 kW gained of 8.6 kWh
    battery_rest_s_min    planned standing before a shuttle can have charged: the way to a charger and back
    relocates             idle shuttles move to where riders are expected
    relocation_gain_s_min a move must lower the expected mean wait by so much
    relocation_pickups_1ph_min  no vehicle moves while fewer pickups are expected in an hour, in all
    relocation_ahead_s    the time of the expected pickups: about as far ahead as the drive takes
    demand_days, demand_half_life_days, demand_prior_days  how far back bookings are learned from, how soon
                          they count half, and the days without any that are added to them
    quarantine_s          after so long without another breach of the protocol a vehicle gets rides again
    key_conflict_within_s  another boot that was heard within this time still runs: two agents use one key
    silent_after_s        a vehicle that is not heard for so long is an incident
    order_valid_s         a vehicle accepts an order within this time
    booking_ahead_s_max   how far ahead rides can be booked
    series_ahead_s        a day of a recurring booking gets its ride so long before
    rider_days            so long after its end a ride still names its rider
    series_retry_s        how often a day without a vehicle is tried again
    """

    hours: ServiceHours = field(default_factory=ServiceHours)
    seats_max: int = 6
    speed_cap_mps: float = 3.0
    travel_time_factor: float = 1.55
    dwell_s: float = 15.0
    wait_s_max: float = 1800.0
    detour_ratio_max: float = 2.0
    detour_s_min: float = 600.0
    pickup_early_s: float = 60.0
    pickup_slack_s: float = 300.0
    pickup_slack_ratio: float = 0.1
    uncertain_s_max: float = 1800.0
    arrival_slack_s: float = 300.0
    arrival_slack_ratio: float = 0.5
    promise_lapse_s: float = 20.0
    promise_notice_s: float = 300.0
    promise_reserve_s: float = 60.0
    promise_reserve_ratio: float = 0.1
    walk_m_max: float = 400.0
    walk_mps: float = 1.1
    later_s_max: float = 7200.0
    departure_tolerance_s: float = 120.0
    departure_lead_s: float = 3600.0
    grant_ahead_m: float = 80.0
    braking_mps2: float = 0.8
    reaction_s: float = 1.5
    reassign_after_s: float = 60.0
    order_stops: int = 2
    held_back_s: float = 90.0
    departure_early_s: float = 300.0
    battery_reserve_ratio: float = 0.1
    battery_charge_below_ratio: float = 0.25
    battery_accept_ratio: float = 0.5
    battery_full_ratio: float = 0.95
    battery_per_drive_s: float = 8e-5
    battery_per_charge_s: float = 2.1e-4
    battery_rest_s_min: float = 1800.0
    relocates: bool = True
    relocation_gain_s_min: float = 60.0
    relocation_pickups_1ph_min: float = 0.5
    relocation_ahead_s: float = 900.0
    demand_days: float = 56.0
    demand_half_life_days: float = 14.0
    demand_prior_days: float = 2.0
    quarantine_s: float = 60.0
    key_conflict_within_s: float = 2.0
    silent_after_s: float = 5.0
    order_valid_s: float = 60.0
    booking_ahead_s_max: float = 7 * 86400.0
    series_ahead_s: float = 24 * 3600.0
    series_retry_s: float = 900.0
    operator_session_s: float = 12 * 3600.0
    enrolment_code_s: float = 24 * 3600.0
    history_days: float = 30.0
    video_days: float = 14.0
    scan_days: float = 90.0
    webhook_failure_days: float = 5.0
    rider_days: float = 30.0
    audit_address_days: float = 90.0
    initial_password_s: float = 3 * 86400.0

    def early_s(self, *, timed: bool) -> float:
        """How much earlier than planned a shuttle sets out; timed: to a timetable call."""
        return self.departure_early_s if timed else self.held_back_s

    def ride_s_max(self, direct_s: float) -> float:
        """The longest time on board of a ride that takes direct_s without detours."""
        return max(self.detour_ratio_max * direct_s, direct_s + self.detour_s_min)

    def reserve_s(self, ahead_s: float, *, told_anew: bool) -> float:
        """The part of its slack that a promise, made ahead_s before it is due, keeps from later riders.

        A promise that was made anew keeps all of it, so that no party is delayed twice by others.
        """
        for_the_road_s = self.promise_reserve_s + self.promise_reserve_ratio * self._uncertain_s(ahead_s)
        return for_the_road_s + (self.pickup_slack_s if told_anew else 0.0)

    def _uncertain_s(self, ahead_s: float) -> float:
        return min(max(0.0, ahead_s), self.uncertain_s_max)

    def stopping_m(self, speed_mps: float) -> float:
        """The distance ahead of a shuttle at which it can still stop for a new visit."""
        return speed_mps * self.reaction_s + speed_mps**2 / (2.0 * self.braking_mps2)
