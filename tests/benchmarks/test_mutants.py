"""Wrong changes: what is changed, which tests may notice, and that nothing is left behind."""

import json
from pathlib import Path

import pytest

pytest.importorskip("cosmic_ray", reason="`make mutants` installs it")

from benchmarks.mutants.__main__ import EQUIVALENTS, draw
from benchmarks.mutants.importers import ImportGraph
from benchmarks.mutants.mutations import mutated, mutations_of
from benchmarks.mutants.rooms import ROOMS, ROOT
from benchmarks.mutants.selection import test_files as files_of_tests

TEXT = '''"""Text with 1 < 2 in it."""

LIMIT_NS = 2_000_000_000


@njit(cache=True)
class Kept(Struct, frozen=True):
    count: int = 7


    stamp_ns: int = 0


def warm_kernels():
    clamp(4.5)


def clamp(x, least=0):
    if 0 < x.since_ns <= 8:
        return 5
    if x < least and not x == 3:
        return -x
    return x + least


def number(text):
    try:
        return int(text)
    except (binascii.Error, ValueError):
        return None


def pairs(xs, ys):
    return list(zip(xs, ys, strict=True)) if any(not x.known for x in xs) else []
'''


def changes() -> set[tuple[str, str]]:
    found = (mutated(mutation, TEXT) for mutation in mutations_of("m.py", TEXT))
    return {(change.was, change.now) for change in found}


def test_comparisons_signs_numbers_and_conditions_are_changed() -> None:
    line = "if x < least and not x == 3:"
    for now in (
        "if x <= least and not x == 3:",
        "if x >= least and not x == 3:",
        "if x < least or not x == 3:",
        "if x < least and not x != 3:",
        "if x < least and not x == 4:",
    ):
        assert (line, now) in {(was, " ".join(now.split())) for was, now in changes()}, now
    assert ("return x + least", "return x - least") in changes()


def test_what_is_declared_of_a_kernel_or_a_class_stays_as_it_is_and_what_is_in_it_does_not() -> None:
    assert not any(word in was for word in ("njit", "frozen") for was, _ in changes())
    assert all("strict=True" in now for was, now in changes() if "strict" in was)
    assert ("count: int = 7", "count: int = 8") in changes()


def test_of_exceptions_those_with_a_plain_name_are_changed() -> None:
    line = "except (binascii.Error, ValueError):"
    assert [now for was, now in changes() if was == line] == [
        "except (binascii.Error, CosmicRayTestingException):"
    ]


def test_texts_and_numbers_of_which_one_more_means_nothing_stay_as_they_are() -> None:
    assert not any("Text" in was or "LIMIT_NS" in was for was, _ in changes())


def test_a_nanosecond_more_and_the_values_that_warm_a_kernel_stay_as_they_are() -> None:
    assert not any("stamp_ns" in was or "4.5" in was for was, _ in changes())
    since = {" ".join(now.split()) for was, now in changes() if "since_ns" in was}
    assert since == {"if 0 <= x.since_ns <= 8:", "if 0 >= x.since_ns <= 8:", "if 0 < x.since_ns < 8:",
                     "if 0 < x.since_ns > 8:", "if not 0 < x.since_ns <= 8:"}  # fmt: skip
    assert ("return 5", "return 6") in changes()


def test_the_same_seed_draws_the_same_changes_and_leaves_out_those_known_as_equivalent() -> None:
    room = next(room for room in ROOMS if room.name == "access")
    drawn = draw([room], 5, 3, {})
    assert draw([room], 5, 3, {}) == drawn
    assert draw([room], 5, 4, {}) != drawn
    _, first = drawn[0]
    key = mutated(first, (ROOT / first.path).read_text(encoding="utf-8")).key(first.path)
    assert first not in [mutation for _, mutation in draw([room], 5, 3, {key: "why"})]


def test_a_file_is_tried_on_the_tests_that_mirror_it_first_and_on_those_that_see_it_through_others() -> None:
    room = next(room for room in ROOMS if room.name == "guard")
    near, others = files_of_tests(ImportGraph(ROOT), room, "vehicle_agent/guard/limits.py")
    assert near[0] == "tests/vehicle_agent/guard/test_limits.py"
    assert all(path.startswith("tests/vehicle_agent/guard/") for path in near)
    assert "tests/vehicle_agent/stacks/test_gem_stack.py" in others
    assert not set(near) & set(others)


def test_every_room_has_code_and_tests() -> None:
    for room in ROOMS:
        assert room.files(), room.name
        for folder in room.tests:
            assert list((ROOT / folder).rglob("test_*.py")), room.name


def test_every_equivalent_change_has_a_reason_and_is_of_a_line_that_is_there() -> None:
    known = json.loads(Path(EQUIVALENTS).read_text(encoding="utf-8"))
    for key, reason in known.items():
        path, _, change = key.partition(": ")
        was = change.partition(" -> ")[0]
        assert len(reason) > 20, key
        assert was in " ".join((ROOT / path).read_text(encoding="utf-8").split()), key
