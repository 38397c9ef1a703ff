"""Counts of the code's structure: `python -m benchmarks.house [--json F]`.

Every figure is counted with `ast`, the file list of git and the import graph. No threshold is applied here.
"""

import argparse
import ast
import subprocess
import tomllib
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from grimp import ImportGraph, build_graph
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from benchmarks.reporting.report import RunReport

ROOT = Path(__file__).resolve().parent.parent
PRODUCTION = ("campusloop", "contract", "server", "vehicle_agent", "simulator", "workshop")
NOT_MEASURED = ("tests/", "migrations/versions/")
FILES_PER_FOLDER = 15


@dataclass(frozen=True, slots=True)
class FunctionLength:
    """`lines`: from `def` to the last statement, with comments, without the docstring and blank lines."""

    path: str
    name: str
    lines: int


def main() -> None:
    report = RunReport()
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--json", type=Path, default=None)
    arguments = parser.parse_args()
    tracked = tracked_files()
    lengths = sorted(
        (
            length
            for path in tracked
            if path.endswith(".py") and not path.startswith(NOT_MEASURED)
            for length in function_lengths(path, (ROOT / path).read_text(encoding="utf-8"))
        ),
        key=lambda length: length.lines,
    )
    folders = crowded_folders(tracked)
    graph = build_graph(*PRODUCTION, include_external_packages=False)
    cycles = import_cycles(graph)
    upward = upward_imports(graph, layer_contracts())
    any_uses = {
        path: uses
        for path in tracked
        if path.startswith(tuple(f"{package}/" for package in PRODUCTION)) and path.endswith(".py")
        if (uses := uses_of_any((ROOT / path).read_text(encoding="utf-8")))
    }
    rows: list[dict[str, float | int | str]] = [
        {"kind": "function", "where": f"{length.path}:{length.name}", "count": length.lines}
        for length in reversed(lengths[-10:])
    ]
    rows += [{"kind": "folder", "where": folder, "count": files} for folder, files in folders.items()]
    rows += [{"kind": "cycle", "where": " ".join(cycle), "count": len(cycle)} for cycle in cycles]
    rows += [
        {"kind": "upward import", "where": f"{importer} -> {imported}", "count": 1}
        for importer, imported in upward
    ]
    rows += [
        {"kind": "Any", "where": path, "count": uses}
        for path, uses in sorted(any_uses.items(), key=lambda item: -item[1])[:10]
    ]
    summary = {
        "functions": len(lengths),
        "longest_function": lengths[-1].lines,
        "function_p95": lengths[int(0.95 * len(lengths))].lines,
        "folders_over_15": len(folders),
        "cycles": len(cycles),
        "upward_imports": len(upward),
        "any_in_production": sum(any_uses.values()),
    }
    report.write(arguments.json, "house", {}, rows, summary)


def tracked_files() -> list[str]:
    """Every file of the checkout that git knows, as paths from its root."""
    listed = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=True)
    return [path for path in listed.stdout.splitlines() if (ROOT / path).is_file()]


def function_lengths(path: str, source: str) -> Iterator[FunctionLength]:
    """Every function and method of a file, nested ones too."""
    lines = source.splitlines()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            docstring = _docstring_lines(node)
            counted = sum(
                1
                for number in range(node.lineno, (node.end_lineno or node.lineno) + 1)
                if number not in docstring and lines[number - 1].strip()
            )
            yield FunctionLength(path, node.name, counted)


def _docstring_lines(node: ast.FunctionDef | ast.AsyncFunctionDef) -> range:
    if ast.get_docstring(node, clean=False) is None:
        return range(0)
    first = node.body[0]
    return range(first.lineno, (first.end_lineno or first.lineno) + 1)


def crowded_folders(tracked: Sequence[str]) -> dict[str, int]:
    """Folders with more files than a reader takes in at once; subfolders and `__init__.py` do not count."""
    sizes = Counter(path.rpartition("/")[0] for path in tracked if not path.endswith("/__init__.py"))
    return {folder: files for folder, files in sizes.most_common() if files > FILES_PER_FOLDER}


def import_cycles(graph: ImportGraph) -> list[list[str]]:
    """Groups of modules that import each other, imports for types and inside functions included."""
    names = sorted(graph.modules)
    index = {name: number for number, name in enumerate(names)}
    edges = np.array(
        [
            (index[name], index[imported])
            for name in names
            for imported in graph.find_modules_directly_imported_by(name)
        ]
    )
    matrix = coo_array((np.ones(len(edges)), (edges[:, 0], edges[:, 1])), shape=(len(names), len(names)))
    _, labels = connected_components(matrix, directed=True, connection="strong")
    groups: dict[int, list[str]] = {}
    for name, label in zip(names, labels, strict=True):
        groups.setdefault(int(label), []).append(name)
    return sorted(group for group in groups.values() if len(group) > 1)


def layer_contracts() -> list[list[list[str]]]:
    """The layers that pyproject.toml declares, top first; one layer may hold several packages."""
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    contracts: list[Mapping[str, Any]] = settings["tool"]["importlinter"]["contracts"]
    found = []
    for contract in contracts:
        if contract["type"] == "layers":
            containers = contract.get("containers", [""])
            for container in containers:
                prefix = f"{container}." if container else ""
                found.append(
                    [
                        [prefix + name.strip(" ()") for name in layer.replace(":", "|").split("|")]
                        for layer in contract["layers"]
                    ]
                )
    return found


def upward_imports(graph: ImportGraph, contracts: Sequence[Sequence[Sequence[str]]]) -> list[tuple[str, str]]:
    """Imports from a lower layer to a higher one, or between packages that share a layer."""
    found = set()
    for layers in contracts:
        height = {package: level for level, layer in enumerate(layers) for package in layer}
        for module in graph.modules:
            importer = _package_of(module, height)
            if importer is None:
                continue
            for imported in graph.find_modules_directly_imported_by(module):
                package = _package_of(imported, height)
                if package is not None and package != importer and height[package] <= height[importer]:
                    found.add((module, imported))
    return sorted(found)


def _package_of(module: str, packages: Mapping[str, int]) -> str | None:
    parts = module.split(".")
    prefixes = (".".join(parts[:count]) for count in range(len(parts), 0, -1))
    return next((prefix for prefix in prefixes if prefix in packages), None)


def uses_of_any(source: str) -> int:
    """How often a file names `typing.Any` in an annotation or elsewhere, imports left out."""
    return sum(isinstance(node, ast.Name) and node.id == "Any" for node in ast.walk(ast.parse(source)))


if __name__ == "__main__":
    main()
