"""How often the tick runs, and how old each of its inputs may be.

Every room that asks for the age of an input reads it here.
"""

TICK_NS = 20_000_000
# A longer tick is a fault; a tick lost for longer stops the vehicle.
LATE_TICK_FAULT_NS = 60_000_000
LOST_TICK_FAULT_NS = 500_000_000
REPORT_EVERY_TICKS = 10
TRANSFORM_EVERY_TICKS = 5

# An older input is stale. In brackets, how often it comes.
CAN_FRAME_AGE_NS_MAX = 150_000_000  # (30 Hz)
POSE_AGE_NS_MAX = 300_000_000  # (50 Hz)
PERCEPT_AGE_NS_MAX = 400_000_000  # (10 Hz)
PATH_AGE_NS_MAX = 200_000_000  # (10 Hz)
PLAN_ANSWER_AGE_NS_MAX = 400_000_000  # (10 Hz)
FLEET_VEHICLE_AGE_NS_MAX = 1_500_000_000  # (5 Hz)
PRESENCE_AGE_NS_MAX = 2_500_000_000  # (1 Hz)
