"""Which compiled kernels are kept, with numba's own files and with a stand-in for them."""

import ast
import os
import subprocess
import sys
from pathlib import Path

import pytest

from campusloop.kernels.caches import CachesNotWritable, KernelCaches
from tests.campusloop.kernels.kernel_tree import GROUPS, a_tree, change, sources


def caches(root: Path) -> KernelCaches:
    return KernelCaches(sources(root), GROUPS)


def compiled(root: Path) -> Path:
    """The tree as it is after both groups have been compiled; numba's files are empty ones."""
    (a_tree(root) / "campusloop").mkdir()
    folder = root / "rooms" / "__pycache__"
    folder.mkdir()
    assert caches(root).missing(tuple(GROUPS)) == ("upper", "alone")
    for name in ("upper.length-6", "lower.twice-6", "alone.half-4"):
        (folder / f"{name}.py311.nbi").touch()
        (folder / f"{name}.py311.1.nbc").touch()
    for group in GROUPS:
        caches(root).record_complete(group)
    return root


def kept(root: Path) -> set[str]:
    return {path.name.split(".")[0] for path in (root / "rooms" / "__pycache__").glob("*.nb[ic]")}


def test_what_is_compiled_is_not_compiled_again(tmp_path: Path) -> None:
    root = compiled(tmp_path)
    assert caches(root).missing(tuple(GROUPS)) == ()
    assert kept(root) == {"upper", "lower", "alone"}


def test_only_the_groups_that_are_asked_for_are_missing(tmp_path: Path) -> None:
    (a_tree(tmp_path) / "campusloop").mkdir()
    assert caches(tmp_path).missing(("alone",)) == ("alone",)


def test_a_changed_kernel_takes_those_with_it_that_call_it_and_no_others(tmp_path: Path) -> None:
    root = compiled(tmp_path)
    change(root, "rooms/lower.py", "2.0 * x", "3.0 * x")
    assert caches(root).missing(tuple(GROUPS)) == ("upper",)
    assert kept(root) == {"alone"}


def test_a_change_of_what_no_kernel_uses_keeps_all(tmp_path: Path) -> None:
    root = compiled(tmp_path)
    change(root, "rooms/limits.py", "MOST = 9.0", "MOST = 8.0")
    assert caches(root).missing(tuple(GROUPS)) == ()
    assert kept(root) == {"upper", "lower", "alone"}


def test_caches_of_unknown_origin_are_deleted(tmp_path: Path) -> None:
    root = compiled(tmp_path)
    (root / "campusloop" / "__pycache__" / "kernels.json").unlink()
    assert caches(root).missing(tuple(GROUPS)) == ("upper", "alone")
    assert kept(root) == set()


def test_a_cache_that_somebody_deleted_is_missed(tmp_path: Path) -> None:
    root = compiled(tmp_path)
    (root / "rooms" / "__pycache__" / "lower.twice-6.py311.nbi").unlink()
    assert caches(root).missing(tuple(GROUPS)) == ("upper",)


@pytest.mark.parametrize("text", ["", "{", '{"written": 3}'])
def test_a_record_that_cannot_be_read_is_as_none(tmp_path: Path, text: str) -> None:
    root = compiled(tmp_path)
    (root / "campusloop" / "__pycache__" / "kernels.json").write_text(text)
    assert caches(root).missing(tuple(GROUPS)) == ("upper", "alone")


def warmed(root: Path) -> float:
    """What the tree's kernels give in a process of their own."""
    done = subprocess.run(
        [sys.executable, "-c", "from rooms.warm import warm; print(warm())"],
        cwd=root,
        # Python takes a change of the same length within a second for none, and would run its old bytecode.
        env={"PYTHONPATH": str(root), "PATH": "", "PYTHONDONTWRITEBYTECODE": "1"},
        capture_output=True,
        text=True,
        check=True,
    )
    return float(done.stdout)


def test_numba_itself_then_compiles_what_calls_a_changed_kernel(tmp_path: Path) -> None:
    """And not without: its own cache gives the old result, which is why there is all this."""
    root = a_tree(tmp_path)
    (root / "campusloop").mkdir()
    caches(root).missing(("upper",))
    assert warmed(root) == 3.0
    change(root, "rooms/limits.py", "LEAST = 1.0", "LEAST = 2.0")
    assert warmed(root) == 3.0
    assert caches(root).missing(("upper",)) == ("upper",)
    assert warmed(root) == 4.0


def test_unchanged_sources_are_not_parsed_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Parsing ours takes more than a second, at every start of every command."""
    root = compiled(tmp_path)
    caches(root).missing(tuple(GROUPS))
    monkeypatch.setattr(ast, "parse", None)
    assert caches(root).missing(tuple(GROUPS)) == ()


def test_a_group_stays_missing_until_it_is_compiled(tmp_path: Path) -> None:
    root = compiled(tmp_path)
    change(root, "rooms/lower.py", "2.0 * x", "3.0 * x")
    for _ in range(2):
        assert caches(root).missing(tuple(GROUPS)) == ("upper",)
        (root / "rooms" / "__pycache__" / "lower.twice-6.py311.nbi").touch()
        (root / "rooms" / "__pycache__" / "upper.length-6.py311.nbi").touch()
    caches(root).record_complete("upper")
    assert caches(root).missing(tuple(GROUPS)) == ()


def test_a_tree_that_cannot_be_written_is_named(tmp_path: Path) -> None:
    """A folder in the file's place stands for missing rights, which the superuser would not notice."""
    root = a_tree(tmp_path)
    (root / "campusloop" / "__pycache__" / f"kernels.{os.getpid()}").mkdir(parents=True)
    with pytest.raises(CachesNotWritable, match="kernels"):
        caches(root).missing(tuple(GROUPS))


def test_a_look_at_what_is_compiled_deletes_and_writes_nothing(tmp_path: Path) -> None:
    root = compiled(tmp_path)
    assert caches(root).not_known_complete(tuple(GROUPS)) == ()
    os.utime(root / "rooms" / "upper.py", ns=(1, 1))
    before = {path: path.stat().st_mtime_ns for path in root.rglob("*")}
    assert caches(root).not_known_complete(tuple(GROUPS)) == tuple(GROUPS)
    assert {path: path.stat().st_mtime_ns for path in root.rglob("*")} == before
