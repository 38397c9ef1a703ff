"""The mission's parameters."""

import msgspec

from contract.roads.design_vehicle import RELEASE_MARGIN_M, STANDING_MARGIN_M
from vehicle_agent.mission.seat_button import StopRules
from vehicle_agent.mission.sections import VehicleExtent


class MissionRules(msgspec.Struct, frozen=True):
    """Times in ns, lengths in m.

    section_margin_m   kept between the front bumper and a section without a grant
    release_slack_m    how far the rear bumper must be out of a section before the section is released
    docked_m           a vehicle that stands this near before a stop has arrived
    arrived_m, creep_ns  one that stands this near for this long, and has not driven on, has arrived as well
    overshot_m         or this far beyond: a stop ordered too late to brake for is served from there
    standing_*         a vehicle stands when it is slower than this for this long
    rolling_mps        a faster vehicle with open doors closes them
    alight_grace_ns    how much longer than the dwell the doors stay open for riders who should alight
    near_*, beside_m   departure check of a temporary stop: no person is within near_m, and nothing stands
                       before the bumper within near_m or alongside within beside_m, for near_clear_ns. Only
                       an operator's resume ends the wait for people who stay; the operator hears of it
                       after near_report_ns
    occupied_*         another vehicle stands on the stop: wait this far behind where a docked one ends, until
                       the stop has been free for this long
    off_route_m        a vehicle farther beside its line is off its route
    hold_*             reaction time and deceleration of a hold command
    """

    body: VehicleExtent
    half_width_m: float
    stops: StopRules
    hold_decel_mps2: float
    section_margin_m: float = STANDING_MARGIN_M
    release_slack_m: float = RELEASE_MARGIN_M
    docked_m: float = 0.2
    arrived_m: float = 0.5
    creep_ns: int = 3_000_000_000
    overshot_m: float = 1.5
    standing_mps: float = 0.05
    standing_ns: int = 300_000_000
    rolling_mps: float = 0.3
    door_travel_ns: int = 1_500_000_000
    temporary_dwell_ns: int = 8_000_000_000
    alight_grace_ns: int = 10_000_000_000
    near_m: float = 1.5
    near_clear_ns: int = 1_000_000_000
    near_report_ns: int = 30_000_000_000
    beside_m: float = 0.5
    occupied_gap_m: float = 2.0
    occupied_clear_ns: int = 1_000_000_000
    off_route_m: float = 2.5
    hold_reaction_s: float = 0.4
