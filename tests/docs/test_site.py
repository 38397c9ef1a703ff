"""The documentation site: what is in it, and what its links become."""

from pathlib import Path

import pytest

from docs.site.build import ROOT, lay_out, page_files, without_code_links


@pytest.fixture
def repository(tmp_path: Path) -> Path:
    for name in ("README.md", "docs/web.md", "docs/site/index.md", "server/app.py", "docs/images/a.png"):
        path = tmp_path / "repository" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("[code](server/app.py), [page](docs/web.md)" if name == "README.md" else name)
    return tmp_path / "repository"


def test_pages_and_pictures_are_laid_out_under_their_own_paths_without_code(
    repository: Path, tmp_path: Path
) -> None:
    source = tmp_path / "source"
    lay_out(repository, source)
    found = {str(path.relative_to(source)) for path in source.rglob("*") if path.is_file()}
    assert found == {"README.md", "docs/web.md", "docs/images/a.png", "index.md"}
    assert (source / "README.md").read_text() == "code, [page](docs/web.md)"


@pytest.mark.parametrize(
    ("page", "text", "shown"),
    [
        ("docs/web.md", "[`app`](../server/app.py)", "`app`"),
        ("docs/web.md", "[rooms](../server)", "rooms"),
        ("docs/web.md", "[start](../README.md#top)", "[start](../README.md#top)"),
        ("README.md", "![picture](docs/images/a.png)", "![picture](docs/images/a.png)"),
        ("README.md", "[paper](https://example.org/a)", "[paper](https://example.org/a)"),
        # Sphinx tells of it.
        ("README.md", "[gone](docs/gone.md)", "[gone](docs/gone.md)"),
    ],
)
def test_links_to_code_are_text_and_all_others_stay(
    repository: Path, page: str, text: str, shown: str
) -> None:
    staged = frozenset(page_files(repository))
    assert without_code_links(text, Path(page), repository, staged) == shown


def test_every_page_of_the_repository_is_in_the_site() -> None:
    staged = {str(path) for path in page_files(ROOT)}
    assert {"README.md", "ARCHITECTURE.md", "docs/server/api.md", "docs/vehicle/planning/motion.md"} <= staged
    assert "docs/site/index.md" not in staged
