"""Who must never wait for the rest of the machine asks for it."""

import os

import structlog

log = structlog.get_logger()

# Who brakes goes before who drives.
GATE_PRIORITY, TICK_PRIORITY = 20, 10


def ask_for_real_time(name: str, priority: int) -> bool:
    """Before everybody else on this machine, from now on; only for a process that mostly sleeps.

    False where the system does not know this or does not allow it (it takes CAP_SYS_NICE); then the process
    goes on as any other, and says so.
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
