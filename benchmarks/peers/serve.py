"""The planner's process: `python -m benchmarks.peers.serve PLANNER SETTING`, with the planner's interpreter.

Reads `Road` and `PlanRequest` from standard input, writes `Ready` and `Plan` to standard output. The
planner's own output goes to standard error.
"""

import os
import sys
import time
from collections.abc import Sequence
from importlib import metadata
from typing import Any, Protocol

import msgspec

from benchmarks.peers.messages import Plan, PlanRequest, Ready, Road, ToPlanner


class OpenPlanner(Protocol):
    """One planner behind one setting.

    begin takes a scene; prepare converts a PlanRequest to the planner's own input; plan is its own call; rows
    converts its result to PLAN_COLUMNS, empty for none, with its status text.
    """

    package: str

    def begin(self, road: Road) -> None: ...

    def prepare(self, request: PlanRequest) -> None: ...

    def plan(self) -> Any: ...

    def rows(self, found: Any) -> tuple[Sequence[tuple[float, ...]], str]: ...


def planner_of(name: str, setting: str) -> OpenPlanner:
    """Imported only here: each lives in an environment of its own. ValueError for an unknown one."""
    if name == "reactive":
        from benchmarks.peers.reactive import Reactive

        return Reactive(setting)
    if name == "fiss":
        from benchmarks.peers.fiss import Fiss

        return Fiss(setting)
    raise ValueError(f"there is no open planner {name!r}; there are: reactive, fiss")


def answer(planner: OpenPlanner, request: PlanRequest) -> Plan:
    """One timed cycle. A planner that raises has no plan; its error is reported."""
    begun = time.process_time_ns()
    planner.prepare(request)
    cpu, wall = time.process_time_ns(), time.perf_counter_ns()
    prepare_ms = 1e-6 * (cpu - begun)
    raised = ""
    found = None
    try:
        found = planner.plan()
    except (ArithmeticError, AssertionError, LookupError, RuntimeError, TypeError, ValueError) as error:
        raised = f"{type(error).__name__}: {error}"
    cycle_cpu_ms = 1e-6 * (time.process_time_ns() - cpu)
    cycle_wall_ms = 1e-6 * (time.perf_counter_ns() - wall)
    rows, words = planner.rows(found) if not raised else ((), raised)
    return Plan([tuple(map(float, row)) for row in rows], words, cycle_cpu_ms, cycle_wall_ms, prepare_ms)


def main() -> None:
    name, setting = sys.argv[1:]
    out = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    planner = planner_of(name, setting)
    about = metadata.metadata(planner.package)
    licence = about.get("License-Expression") or about.get("License") or "not stated"
    _send(out, Ready(f"{name} {setting}", metadata.version(planner.package), licence))
    decoder = msgspec.json.Decoder(ToPlanner)
    for line in sys.stdin.buffer:
        said = decoder.decode(line)
        if isinstance(said, Road):
            planner.begin(said)
        else:
            _send(out, answer(planner, said))


def _send(out: Any, message: Ready | Plan) -> None:
    out.write(msgspec.json.encode(message) + b"\n")
    out.flush()


if __name__ == "__main__":
    main()
