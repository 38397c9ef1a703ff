"""What passengers ask for on the onboard screen: help, and another destination."""

from contract.wire.messages import CodeRefused, DestinationRequested, HelpRequested, RiderTask
from tests.vehicle_agent.mission.ring import RingShuttle
from vehicle_agent.mission.boarding import take_destination
from vehicle_agent.mission.memory import MissionMemory
from vehicle_agent.signals import DestinationChoice, HelpButton

ANN, BOB = RiderTask("ann", 1, "1111"), RiderTask("bob", 2, "2222")


def test_a_call_for_help_is_reported_with_its_seat() -> None:
    shuttle = RingShuttle()
    shuttle.step(HelpButton(0, 3))
    assert shuttle.of(HelpRequested) == [HelpRequested(3)]


def test_the_only_party_aboard_needs_no_code() -> None:
    memory = MissionMemory(aboard=(ANN,))
    assert take_destination(memory, "v", "", "library") == DestinationRequested("ann", "library")


def test_of_two_parties_the_code_says_which_one_goes_elsewhere() -> None:
    memory = MissionMemory(aboard=(ANN, BOB))
    assert take_destination(memory, "v", "", "library") == CodeRefused("v")
    assert take_destination(memory, "v", "2222", "library") == DestinationRequested("bob", "library")


def test_a_code_of_nobody_aboard_is_refused() -> None:
    assert take_destination(MissionMemory(aboard=(ANN,)), "v", "9999", "library") == CodeRefused("v")
    assert take_destination(MissionMemory(), "v", "", "library") == CodeRefused("v")


def test_a_stop_that_the_map_does_not_have_is_refused() -> None:
    shuttle = RingShuttle(MissionMemory(aboard=(ANN,)))
    shuttle.step(DestinationChoice(0, "", "atlantis"))
    assert shuttle.of(DestinationRequested) == []
    assert shuttle.of(CodeRefused) == [CodeRefused("")]
