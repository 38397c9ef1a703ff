"""People of the model have the parameters that their page gives."""

from simulator.traffic.aware.params import ReactionParams
from tests.documented import differing


def test_the_page_gives_the_parameters_of_the_reaction() -> None:
    assert differing("simulator/recorded-crowds.md", (ReactionParams,)) == []
