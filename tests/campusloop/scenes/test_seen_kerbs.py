"""A kerb that the map does not know: the shuttle passes a parked car beside it, or waits, but not over it."""

from dataclasses import replace
from typing import Any

import msgspec
import numpy as np
import pytest

from campusloop.scenes.drive import Scene, SceneDrive, SceneRun
from campusloop.scenes.path_map import path_map
from campusloop.scenes.stacks import profile_of
from simulator.traffic.replayed import ReplayedTraffic
from simulator.traffic.scripted_clips import clip_of, standing
from simulator.world import WorldOptions
from vehicle_agent.onboard.car import Car
from vehicle_agent.signals import VEHICLE

PROFILE = profile_of("snow_lion")
HALF_M = 0.5 * PROFILE.body.width_m
CAR_S_M = 40.0


class SeesKerb:
    """Perception that sees a kerb to the left of the whole way besides."""

    def __init__(self, perception: Any, aside_m: float) -> None:
        self._perception = perception
        along = np.arange(0.0, 100.0, 0.25)
        self._kerbs_map = np.column_stack((along, np.full(len(along), aside_m)))

    def __getattr__(self, name: str) -> Any:
        return getattr(self._perception, name)

    def step(self, state: Any, percepts: Any, ego: Any) -> Any:
        detections, state = self._perception.step(state, percepts, ego)
        return msgspec.structs.replace(detections, kerbs_map=self._kerbs_map), state


def drive(kerb_m: float | None) -> SceneRun:
    points = np.column_stack((np.arange(0.0, 101.0), np.zeros(101)))
    scene = Scene(
        "kerb",
        path_map("kerb", points, width_m=6.0, speed_limit_mps=4.2),
        PROFILE,
        start_s_m=15.0,
        start_mps=2.0,
        goal_s_m=60.0,
        limit_s=35.0,
        seed=1,
        actors=ReplayedTraffic(clip_of("kerb", (standing(1, VEHICLE, CAR_S_M, -1.4),)), 0.0),
        options=WorldOptions(traffic=None),
    )

    def adapt(car: Car) -> Car:
        if kerb_m is None:
            return car
        return replace(car, perception=SeesKerb(car.perception, kerb_m))

    return SceneDrive(scene, adapt=adapt).run()


@pytest.mark.parametrize(("kerb_m", "arrives"), [(None, True), (2.6, True), (1.5, False)])
def test_a_shuttle_passes_a_parked_car_beside_a_kerb_and_not_over_it(
    kerb_m: float | None, arrives: bool
) -> None:
    run = drive(kerb_m)
    assert (run.time_s is not None) == arrives
    assert run.metrics.front_contacts == ()
    if kerb_m is not None:
        rows = run.trace.array()
        assert rows[:, 2].max() + HALF_M < kerb_m
