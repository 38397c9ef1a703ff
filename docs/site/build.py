"""Builds the documentation as a site: `make docs`, or `python -m docs.site.build [OUT]` beside Sphinx.

The pages are those of the repository, under their own paths. Whatever Sphinx warns of ends the build: a page
that nothing leads to, a link to a page or heading that is not there.
"""

import os
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
SITE = Path("docs/site")
OUT = ROOT / "var" / "docs"
_PAGES = (
    "*.md", "benchmarks/README.md", "sdk/python/README.md", "maps/*/*.md",
    "docs/**/*.md", "docs/images/*", "docs/protocol/*.yaml",
)  # fmt: skip
_LINK = re.compile(r"(?<!!)\[([^\]]+)\]\(([^)#\s]+)(?:#[^)\s]*)?\)")


def page_files(root: Path) -> Iterator[Path]:
    """Every page, picture and protocol document, relative to root."""
    for pattern in _PAGES:
        for path in sorted(root.glob(pattern)):
            relative = path.relative_to(root)
            if SITE not in relative.parents:
                yield relative


def without_code_links(text: str, page: Path, root: Path, staged: frozenset[Path]) -> str:
    """The page with links to code as plain text: the site has no code. Links to what is not there stay."""

    def plain(match: re.Match[str]) -> str:
        target = Path(os.path.normpath(page.parent / match[2]))
        is_code = "://" not in match[2] and target not in staged and (root / target).exists()
        return match[1] if is_code else match[0]

    return _LINK.sub(plain, text)


def lay_out(root: Path, source: Path) -> None:
    """Copies what the site is made of into the new folder source."""
    files = tuple(page_files(root))
    staged = frozenset(files)
    for path in files:
        copy = source / path
        copy.parent.mkdir(parents=True, exist_ok=True)
        if path.suffix == ".md":
            text = (root / path).read_text(encoding="utf-8")
            copy.write_text(without_code_links(text, path, root, staged), encoding="utf-8")
        else:
            shutil.copyfile(root / path, copy)
    shutil.copyfile(root / SITE / "index.md", source / "index.md")


def main() -> int:
    out = Path(sys.argv[1]).resolve() if len(sys.argv) > 1 else OUT
    source = out / "source"
    shutil.rmtree(source, ignore_errors=True)
    lay_out(ROOT, source)
    sphinx = [sys.executable, "-m", "sphinx", "-q", "-W", "--keep-going", "-b", "html"]
    built = subprocess.run([*sphinx, "-c", ROOT / SITE, source, out / "html"], check=False)
    if built.returncode == 0:
        print(f"open {out / 'html' / 'index.html'}")
    return built.returncode


if __name__ == "__main__":
    sys.exit(main())
