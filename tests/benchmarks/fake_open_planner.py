"""A planner's process whose planner is made up: straight on at the speed it is asked with."""

import os
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from benchmarks.peers import serve
from benchmarks.peers.messages import PlanRequest, Road


class Straight:
    """Below 0 m/s it raises, at 50 m/s it never answers, at 99 m/s its process ends."""

    package = "msgspec"

    def begin(self, road: Road) -> None:
        print("planners print what they like", road.width_m)

    def prepare(self, ask: PlanRequest) -> None:
        self._ask = ask
        until_ns = time.process_time_ns() + 30_000_000
        while time.process_time_ns() < until_ns:
            pass

    def plan(self) -> float:
        speed_mps = self._ask.v_mps
        if speed_mps < 0.0:
            raise ValueError("a negative speed")
        if speed_mps == 50.0:
            time.sleep(600.0)
        if speed_mps == 99.0:
            os._exit(7)
        return speed_mps

    def rows(self, found: float) -> tuple[list[tuple[float, ...]], str]:
        return [(0.1 * k, 0.1 * k * found, 0.0, 0.0, found, 0.0, 0.0) for k in range(20)], "as told"


serve.planner_of = lambda _name, _setting: Straight()
sys.argv = ["serve", "fake", "straight"]
serve.main()
