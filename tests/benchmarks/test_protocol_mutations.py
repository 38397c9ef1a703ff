"""The table of protocol mutations fits the code that it changes."""

import ast

import pytest

from benchmarks.mutants.rooms import ROOT
from benchmarks.protocol_mutations.__main__ import changed_text
from benchmarks.protocol_mutations.table import MUTATIONS, ProtocolMutation


@pytest.mark.parametrize("mutation", MUTATIONS, ids=lambda mutation: mutation.name)
def test_a_mutation_changes_one_place_and_leaves_a_program(mutation: ProtocolMutation) -> None:
    text = (ROOT / mutation.path).read_text(encoding="utf-8")
    ast.parse(changed_text(mutation, text))
    if mutation.test:
        assert (ROOT / mutation.test).is_file()
