"""Real-time priority for gate and tick."""

import os

import structlog

log = structlog.get_logger()

# The gate runs before the tick.
GATE_PRIORITY, TICK_PRIORITY = 20, 10


def ask_for_real_time(name: str, priority: int) -> bool:
    """Requests SCHED_FIFO for this process, which must mostly sleep; True if granted.

    False if the system does not have it or does not allow it (it needs CAP_SYS_NICE). The process then
    continues with normal priority and logs a warning.
    """
    if not hasattr(os, "sched_setscheduler"):
        log.warning("process.not_real_time", name=name, reason="unknown to this system")
        return False
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(priority))
    except PermissionError as error:
        log.warning("process.not_real_time", name=name, reason=str(error))
        return False
    return True
