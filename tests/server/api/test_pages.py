from pathlib import Path

import httpx
import pytest

from server.api.pages import FOR_EVER, REVALIDATE
from tests.server.api.server_under_test import ServerUnderTest


@pytest.fixture
def dist(tmp_path: Path) -> Path:
    for name, text in {
        "index.html": "<p>passenger",
        "console/index.html": "<p>console",
        "assets/app-8f3e21ab.js": "let a",
        "sw.js": "let s",
        "manifest.webmanifest": "{}",
    }.items():
        path = tmp_path / "dist" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    return tmp_path


def fetch(server: ServerUnderTest, path: str, method: str = "GET", **options: object) -> httpx.Response:
    return server.run(server.client.request(method, path, **options))  # type: ignore[arg-type]


def test_both_applications_have_their_shell_and_any_other_path_is_no_page(dist: Path) -> None:
    server = ServerUnderTest(dist)
    for path, text in {"/": "<p>passenger", "/console": "<p>console", "/console/": "<p>console"}.items():
        answer = fetch(server, path)
        assert (answer.status_code, answer.text) == (200, text)
        assert answer.headers["cache-control"] == REVALIDATE
    for path in ("/docs", "/ride/abc", "/console/runs/7", "/favicon.ico"):
        answer = fetch(server, path)
        assert answer.status_code == 404
        assert "There is no page at this address" in answer.text
    server.close()


def test_pages_are_sent_in_the_best_coding_that_the_browser_takes(dist: Path) -> None:
    script = b"let a = 'many words, many words, many words';" * 100
    (dist / "dist" / "assets" / "app-8f3e21ab.js").write_bytes(script)
    (dist / "dist" / "assets" / "app-8f3e21ab.js.br").write_bytes(b"as brotli")
    server = ServerUnderTest(dist)

    def coding(accepted: str) -> str:
        answer = server.run(
            server.client.send(
                server.client.build_request(
                    "GET", "/assets/app-8f3e21ab.js", headers={"Accept-Encoding": accepted}
                ),
                stream=True,
            )
        )
        assert answer.headers["vary"] == "Accept-Encoding"
        return answer.headers.get("content-encoding", "plain")

    assert coding("gzip, deflate, br, zstd") == "br"
    assert coding("gzip, br;q=0") == "gzip"
    assert coding("*;q=0.5") == "br"
    assert coding("identity") == "plain"
    assert coding("gzip;q=nonsense") == "plain"
    assert fetch(server, "/assets/app-8f3e21ab.js", headers={"Accept-Encoding": "gzip"}).content == script
    assert fetch(server, "/assets/app-8f3e21ab.js.br").status_code == 404
    tagged = fetch(server, "/assets/app-8f3e21ab.js", headers={"Accept-Encoding": "gzip"}).headers["etag"]
    assert tagged.endswith('-gzip"')
    assert fetch(server, "/assets/app-8f3e21ab.js", headers={"If-None-Match": tagged}).status_code == 304
    server.close()


def test_hashed_files_are_kept_for_ever_and_others_revalidated(dist: Path) -> None:
    server = ServerUnderTest(dist)
    assert fetch(server, "/assets/app-8f3e21ab.js").headers["cache-control"] == FOR_EVER
    worker = fetch(server, "/sw.js")
    assert worker.headers["cache-control"] == REVALIDATE
    repeated = fetch(server, "/sw.js", headers={"If-None-Match": worker.headers["etag"]})
    assert (repeated.status_code, repeated.content) == (304, b"")
    server.close()


def test_a_missing_file_is_no_page_and_nothing_outside_the_folder_is_served(dist: Path) -> None:
    (dist / "secret.txt").write_text("secret")
    server = ServerUnderTest(dist)
    assert fetch(server, "/assets/app-00000000.js").status_code == 404
    assert "secret" not in fetch(server, "/../secret.txt").text
    assert "secret" not in fetch(server, "/%2e%2e/secret.txt").text
    server.close()


def test_without_built_pages_the_answer_says_how_to_build_them(server: ServerUnderTest) -> None:
    answer = fetch(server, "/")
    assert answer.status_code == 404
    assert "make web" in answer.text


def test_every_answer_tells_the_browser_what_pages_may_do(server: ServerUnderTest) -> None:
    for path in ("/", "/api/v1/health", "/api/v1/nothing-here"):
        headers = fetch(server, path).headers
        assert "script-src 'self'" in headers["content-security-policy"]
        assert "frame-ancestors 'none'" in headers["content-security-policy"]
        assert headers["x-content-type-options"] == "nosniff"
        assert headers["referrer-policy"] == "no-referrer"


def test_an_unknown_api_path_is_a_problem_and_no_page(server: ServerUnderTest) -> None:
    answer = fetch(server, "/api/v1/nothing-here")
    assert answer.status_code == 404
    assert answer.headers["content-type"] == "application/problem+json"
    assert fetch(server, "/anywhere", "POST").status_code == 405
