"""An operator names the vehicle's place: it is tried while it stands, and what came of it is told."""

import msgspec
import pytest

from contract.geometry import Pose2
from contract.roads.network import RoadNetwork
from contract.wire.messages import Command, CommandDone
from contract.wire.reasons import LocalizationPhase
from tests.vehicle_agent.mission.ring import ring
from vehicle_agent.config import Profile
from vehicle_agent.mission.messages import answer_placing, execute_command
from vehicle_agent.mission.mission import Mission
from vehicle_agent.mission.state import MissionState
from vehicle_agent.signals import Ego
from vehicle_agent.stacks.rooms import mission_rules

MISSION = Mission(RoadNetwork(ring()), mission_rules(Profile()))
NAMED = Pose2(10.0, 0.0, 0.0)


def an_ego(phase: LocalizationPhase | None, *, valid: bool = True, speed_mps: float = 0.0) -> Ego:
    pose = Pose2(11.2, 0.0, 0.0)
    return Ego(1, pose, speed_mps, 0.0, 0.0, 0.0, 0.05, 1, valid, (), phase, 0.9)


def told(state: MissionState, ego: Ego, command_id: str = "c-1", pose: Pose2 | None = NAMED) -> MissionState:
    command = Command(1, command_id, "set_position", pose_map=pose)
    return execute_command(state, command, MISSION.network, MISSION.rules, ego)


def later(state: MissionState, seconds: float, ego: Ego) -> MissionState:
    moved = msgspec.structs.replace(state, stamp_ns=state.stamp_ns + round(1e9 * seconds), events=())
    return answer_placing(moved, ego)


def answers(state: MissionState) -> list[tuple[str, bool, str]]:
    return [(e.command_id, e.done, e.detail) for e in state.events if isinstance(e, CommandDone)]


@pytest.fixture
def start() -> MissionState:
    return MISSION.initial()


def test_a_place_that_scans_confirm_is_told_with_its_distance(start: MissionState) -> None:
    state = told(start, an_ego("lost", valid=False))
    assert answers(state) == []
    state = later(state, 3.0, an_ego("doubtful", valid=False))
    assert answers(state) == []
    state = later(state, 1.0, an_ego("recovered"))
    assert answers(state) == [("c-1", True, "scans agree, 1.2 m from the named place")]
    assert answers(later(state, 1.0, an_ego("tracking"))) == []
    # A repeat of the done command is not tried again.
    assert told(msgspec.structs.replace(state, events=()), an_ego("tracking")).placing is None


def test_a_place_that_scans_do_not_confirm_fails_after_a_while(start: MissionState) -> None:
    state = told(start, an_ego("waiting", valid=False))
    assert answers(later(state, 19.0, an_ego("doubtful", valid=False))) == []
    ((_, done, detail),) = answers(later(state, 20.5, an_ego("lost", valid=False)))
    assert not done
    assert "do not agree" in detail
    ((_, done, detail),) = answers(later(state, 20.5, an_ego("gnss_only")))
    assert not done
    assert "nothing there" in detail


@pytest.mark.parametrize(
    ("ego", "pose", "why"),
    [
        (an_ego("tracking", speed_mps=0.5), NAMED, "moves"),
        (an_ego(None), NAMED, "GNSS alone"),
        (an_ego("lost", valid=False), None, "no place"),
    ],
)
def test_what_cannot_be_tried_is_refused_at_once(
    start: MissionState, ego: Ego, pose: Pose2 | None, why: str
) -> None:
    state = told(start, ego, pose=pose)
    ((_, done, detail),) = answers(state)
    assert not done
    assert why in detail
    assert state.placing is None


def test_a_repeat_is_tried_once_and_another_place_takes_over(start: MissionState) -> None:
    ego = an_ego("lost", valid=False)
    state = told(start, ego)
    assert told(state, ego) == state
    state = told(state, ego, "c-2")
    assert answers(state) == [("c-1", False, "another place was named")]
    assert state.placing is not None
    assert state.placing.command_id == "c-2"
