"""Wrong changes to a file, one at a time: cosmic-ray's operators, those that look like a slip of a person."""

import ast
import difflib
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from cosmic_ray.ast import ast_nodes, get_ast
from cosmic_ray.mutating import mutate_code
from cosmic_ray.operators.provider import OperatorProvider

_ARITHMETIC = (
    ("Add", "Sub"),
    ("Sub", "Add"),
    ("Mul", "Div"),
    ("Div", "Mul"),
    ("FloorDiv", "Mul"),
    ("Pow", "Mul"),
)
# Each comparison at its boundary and turned round.
_COMPARISONS = (
    ("Lt", "LtE"), ("Lt", "GtE"), ("LtE", "Lt"), ("LtE", "Gt"),
    ("Gt", "GtE"), ("Gt", "LtE"), ("GtE", "Gt"), ("GtE", "Lt"),
    ("Eq", "NotEq"), ("NotEq", "Eq"), ("Is", "IsNot"), ("IsNot", "Is"),
)  # fmt: skip
OPERATORS: tuple[str, ...] = (
    *(f"ReplaceBinaryOperator_{one}_{other}" for one, other in _ARITHMETIC),
    *(f"ReplaceComparisonOperator_{one}_{other}" for one, other in _COMPARISONS),
    "AddNot",
    "ExceptionReplacer",
    "NumberReplacer",
    "ReplaceAndWithOr",
    "ReplaceOrWithAnd",
    "ReplaceBreakWithContinue",
    "ReplaceContinueWithBreak",
    "ReplaceFalseWithTrue",
    "ReplaceTrueWithFalse",
    "ReplaceUnaryOperator_Delete_Not",
    "ReplaceUnaryOperator_Delete_USub",
    "ZeroIterationForLoop",
)
# One more or less of a larger number is a change of less than 5 %: a matter of tuning, not a slip.
_NUMBER_MAX = 20
_PROVIDER = OperatorProvider()


@dataclass(frozen=True, slots=True)
class Mutation:
    """The n-th place in a file where an operator applies."""

    path: str
    operator: str
    occurrence: int


@dataclass(frozen=True, slots=True)
class MutatedFile:
    """text is the whole file after the change; line, was and now are the first line that differs."""

    text: str
    line: int
    was: str
    now: str

    def key(self, path: str) -> str:
        """The same for the same change, also after its line has moved within the file."""
        return f"{path}: {self.was} -> {self.now}"


def mutations_of(path: str, text: str) -> Iterator[Mutation]:
    """Every mutation of the file."""
    nodes = list(ast_nodes(get_ast(text)))
    for name in OPERATORS:
        operator: Any = _PROVIDER[name]()
        occurrence = 0
        for node in nodes:
            for start, end in operator.mutation_positions(node):
                unnoticeable = name == "NumberReplacer" and not _is_noticeable(node)
                impossible = name == "ExceptionReplacer" and _is_dotted(node, start, end)
                if not (_is_declared(node) or _is_warming(node) or unnoticeable or impossible):
                    yield Mutation(path, name, occurrence)
                occurrence += 1


def mutated(mutation: Mutation, text: str) -> MutatedFile:
    """The file with the mutation in it."""
    changed = mutate_code(text, _PROVIDER[mutation.operator](), mutation.occurrence)
    assert changed is not None, mutation
    before, after = text.splitlines(), changed.splitlines()
    matcher = difflib.SequenceMatcher(None, before, after, autojunk=False)
    _, a_from, a_to, b_from, b_to = next(code for code in matcher.get_opcodes() if code[0] != "equal")
    return MutatedFile(changed, a_from + 1, _joined(before[a_from:a_to]), _joined(after[b_from:b_to]))


def _is_declared(node: Any) -> bool:
    """In a decorator, in the head of a class, the star of a signature, or `strict=True` of a zip.

    How a kernel is compiled, that a struct is frozen, that a parameter has a name, that two lists are equally
    long: no test is to notice that; mypy and the linter do.
    """
    below = None
    if node.type == "operator" and node.parent is not None and node.parent.type in ("parameters", "param"):
        return True
    if (
        node.parent is not None
        and node.parent.type == "argument"
        and node.parent.children[0].get_code(include_prefix=False) == "strict"
    ):
        return True
    while node is not None:
        if node.type == "decorator" or (node.type == "classdef" and below is not node.children[-1]):
            return True
        node, below = node.parent, node
    return False


def _is_dotted(node: Any, start: tuple[int, int], end: tuple[int, int]) -> bool:
    """The name of a module's exception: cosmic-ray replaces plain names only, and fails for others."""
    return bool(node.get_leaf_for_position(start).end_pos != end)


def _is_warming(node: Any) -> bool:
    """In a function that calls kernels so that they are compiled: only the types of its values matter."""
    while node is not None:
        if node.type == "funcdef" and node.name.value.startswith("warm"):
            return True
        node = node.parent
    return False


def _is_noticeable(number: Any) -> bool:
    """Whether one more or less of this number is a slip: not of a larger one or a nanosecond."""
    if abs(ast.literal_eval(number.value)) > _NUMBER_MAX:
        return False
    statement = number
    while statement.parent is not None and statement.type not in ("expr_stmt", "comparison", "param"):
        statement = statement.parent
    return not any(leaf.endswith("_ns") for leaf in _names_beside(statement))


def _names_beside(statement: Any) -> Iterator[str]:
    """The names that an assignment gives its value to, a comparison compares, or a parameter has."""
    if statement.type == "comparison":
        compared = statement.children
    elif statement.type in ("expr_stmt", "param"):
        compared = statement.children[:1]
    else:
        return
    for child in compared:
        if child.type == "name":
            yield child.value
        elif child.type in ("atom_expr", "power"):
            last = child.children[-1]
            yield last.children[-1].value if last.type == "trailer" and last.children[0].value == "." else ""


def _joined(lines: list[str]) -> str:
    return " ".join(" ".join(lines).split())
