"""A stop on which another vehicle stands: waited for, short of it, and docked at once it is free."""

from contract.wire.messages import Command
from tests.vehicle_agent.mission.ring import RingShuttle, a_visit, an_order, rest
from vehicle_agent.config import Profile
from vehicle_agent.stacks.rooms import mission_rules

STOP = ("north", 40.0)
VISITS = (a_visit("a", *STOP), rest(STOP))
RULES = mission_rules(Profile())


def on_the_way(seconds: float = 20.0) -> RingShuttle:
    shuttle = RingShuttle()
    shuttle.go(an_order(VISITS))
    shuttle.run(seconds)
    return shuttle


def stop_s_m(shuttle: RingShuttle) -> float:
    found = shuttle.state.target_s_m()
    assert found is not None
    return found


def test_the_shuttle_waits_behind_a_docked_vehicle_and_gives_the_reason() -> None:
    shuttle = on_the_way()
    shuttle.occupied_stops = ("a",)
    shuttle.run(40.0)
    assert shuttle.speed_mps == 0.0
    assert shuttle.task is not None
    assert shuttle.task.reason == "stop_occupied"
    bumper_m = shuttle.state.s_m + RULES.body.front_m
    rear_m = stop_s_m(shuttle) - RULES.body.back_m
    assert 1.5 <= rear_m - bumper_m <= 2.5
    assert shuttle.state.stage == "driving"
    assert not shuttle.state.memory.under_way, "the visit has not begun"


def test_the_shuttle_docks_when_the_stop_has_been_free_for_a_second() -> None:
    shuttle = on_the_way()
    shuttle.occupied_stops = ("a",)
    shuttle.run(40.0)
    shuttle.occupied_stops = ()
    shuttle.run(0.8)
    assert shuttle.speed_mps == 0.0, "one look that misses the vehicle is no reason to go"
    for _ in range(200):
        if shuttle.state.stage == "serving":
            break
        shuttle.step()
    assert shuttle.state.stage == "serving"
    assert shuttle.state.memory.visit_state("a") == "under_way"
    assert abs(shuttle.state.s_m - stop_s_m(shuttle)) < 0.5


def test_a_shuttle_that_stands_nearer_than_the_waiting_place_waits_where_it_stands() -> None:
    shuttle = on_the_way()
    shuttle.run_until(lambda: stop_s_m(shuttle) - shuttle.state.s_m <= 4.0)
    shuttle.step(Command(1, "stay", "stop_now"))
    shuttle.run_until(lambda: shuttle.speed_mps == 0.0)
    standing_m = shuttle.state.s_m
    shuttle.occupied_stops = ("a",)
    shuttle.step(Command(1, "go", "resume"))
    shuttle.run(5.0)
    assert shuttle.state.s_m - standing_m < 0.2
    assert shuttle.state.wait_s_m is not None


def test_another_occupied_stop_does_not_matter() -> None:
    shuttle = on_the_way()
    shuttle.occupied_stops = ("elsewhere",)
    shuttle.run(60.0)
    assert shuttle.state.memory.visit_state("a") == "done"


def test_a_stop_occupied_at_the_last_moment_causes_no_hard_braking() -> None:
    shuttle = on_the_way()
    shuttle.run_until(lambda: stop_s_m(shuttle) - shuttle.state.s_m <= 7.0)
    shuttle.occupied_stops = ("a",)
    speed_mps = shuttle.speed_mps
    task = shuttle.step()
    assert speed_mps**2 / (2.0 * (task.stop_s_m - task.s_m)) < 0.7
    assert task.stop_s_m <= stop_s_m(shuttle)


def test_at_its_own_stop_the_shuttle_waits_for_no_other_vehicle() -> None:
    shuttle = on_the_way()
    shuttle.run_until(lambda: shuttle.state.stage == "serving")
    shuttle.occupied_stops = ("a",)
    shuttle.run(20.0)
    assert shuttle.state.memory.visit_state("a") == "done"
