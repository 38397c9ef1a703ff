"""Closed vocabularies: what limits a vehicle's speed, why it is held, and its faults.

They are types on the wire. The pages' translations are generated from them and do not compile while one is
missing.
"""

from typing import Literal

# What keeps the vehicle from going faster.
SpeedLimitReason = Literal[
    # nothing to drive to, or riders get on and off
    "idle",
    "dwell",
    "hold",
    "no_order",
    # the vehicle cannot plan
    "no_plan",
    "no_position",
    "poor_position",
    "blind",
    "infeasible",
    # the road
    "speed_limit",
    "waypoint_speed",
    "scenario",
    "curve",
    "steering",
    "occlusion",
    "implausible_prediction",
    # where it has to stop or to slow
    "stop",
    "stop_occupied",
    "stop_sign",
    "yield_sign",
    "section",
    "crossing",
    "crossing_traffic",
    "reported_pedestrians",
    # what is in its way or beside it
    "obstacle",
    "blocked",
    "cost_map",
    "gap",
    "footprint",
    "yielding",
    "emergency",
    "passing",
    "pedestrian_clearance",
    # the vehicle itself
    "acceleration",
]

# Why the vehicle does not drive by itself.
HoldReason = Literal[
    "just_started",
    "operator_hold",
    "operator_stop",
    "off_map",
    "off_route",
    "unreachable_visit",
    "takeover",
    "fault",
]

# How localization by scans is doing.
LocalizationPhase = Literal[
    "waiting",
    "tracking",
    "doubtful",
    "lost",
    "recovered",
    "gnss_only",
]

FaultSeverity = Literal["info", "warning", "stop"]

FaultCode = Literal[
    # inputs of the tick
    "motion_missing",
    "motion_stale",
    "pose_missing",
    "pose_stale",
    "pose_poor",
    "pose_jump",
    "pose_not_finite",
    "localization_silent",
    "percept_missing",
    "percept_stale",
    "path_missing",
    "path_stale",
    "tracks_not_finite",
    "lidar_blind",
    "lidar_silent",
    "lidar_unusable",
    "lidar_moved",
    "command_not_finite",
    # the computer
    "clock_went_back",
    "tick_late",
    "tick_lost",
    # drive-by-wire
    "by_wire_not_given",
    "bywire_accelerator_fault",
    "bywire_brake_fault",
    "bywire_component_fault",
    "bywire_fault",
    "bywire_gear_mismatch",
    "bywire_lost",
    "bywire_lost_in_part",
    "bywire_refuses_enable",
    "bywire_shift_fault",
    "bywire_signal_fault",
    "bywire_speed_mismatch",
    "bywire_steering_fault",
    "bywire_timeout",
    "bywire_wheel_mismatch",
    "stop_button_fault",
    "steering_unlike_profile",
    "pedals_unlike_profile",
    "emergency_stop_pressed",
    "can_frame_malformed",
    "can_accelerator_report_lost",
    "can_brake_report_lost",
    "can_component_report_lost",
    "can_drive_report_lost",
    "can_encoder_report_lost",
    "can_global_report_lost",
    "can_speed_report_lost",
    "can_steering_report_lost",
    "can_throttle_report_lost",
    # the gate brakes by itself
    "gate_braking_clock_jumped",
    "gate_braking_commands_refused",
    "gate_braking_footprint",
    "gate_braking_module_lost",
    "gate_braking_steering_stuck",
    "gate_braking_tick_late",
    "gate_braking_too_fast",
]
