"""What browsers are told of our pages, by the whole application."""

from pathlib import Path

import pytest

from server.api.security.headers import HEADERS, HSTS, SecurityHeaders
from tests.server.api.server_under_test import ServerUnderTest

Told = dict[str, str]


async def answered(
    told: Told, with_tls: bool = False, kind: str = "http", path: str = "/", status: int = 200
) -> list[Told]:
    """The headers of each message that leaves an application which sets these itself."""

    async def app(scope, receive, send):  # type: ignore[no-untyped-def]
        raw = [(name.lower().encode(), value.encode()) for name, value in told.items()]
        start = "http.response.start" if kind == "http" else "websocket.accept"
        await send({"type": start, "status": status, "headers": raw})
        await send({"type": "http.response.body", "body": b""})

    sent: list[Told] = []

    async def send(message):  # type: ignore[no-untyped-def]
        if "headers" in message:
            sent.append({name.decode(): value.decode() for name, value in message["headers"]})

    async def receive():  # type: ignore[no-untyped-def]
        raise AssertionError("nothing is read")

    await SecurityHeaders(app, with_tls)({"type": kind, "path": path}, receive, send)
    return sent


def test_every_answer_of_the_server_carries_them(server: ServerUnderTest) -> None:
    for path in ("/campus", "/vehicles", "/nothing-here"):
        answer = server.get(path)
        for name, value in HEADERS.items():
            assert answer.headers[name] == value, path
        assert "Strict-Transport-Security" not in answer.headers


def test_scripts_come_from_us_alone_and_nobody_frames_a_page() -> None:
    policy = dict(part.split(" ", 1) for part in HEADERS["Content-Security-Policy"].split("; "))
    assert policy["default-src"] == policy["script-src"] == policy["connect-src"] == "'self'"
    assert policy["frame-ancestors"] == policy["object-src"] == policy["base-uri"] == "'none'"
    assert HEADERS["Referrer-Policy"] == "no-referrer"


@pytest.mark.parametrize("with_tls", [True, False])
def test_only_a_server_with_a_certificate_asks_for_encrypted_visits_from_now_on(
    server: ServerUnderTest, with_tls: bool
) -> None:
    (told,) = server.run(answered({}, with_tls))
    assert told.get("strict-transport-security") == (HSTS if with_tls else None)


def test_a_file_that_a_page_asks_for_carries_what_is_of_use_there(server: ServerUnderTest) -> None:
    (told,) = server.run(answered({}, True, path="/assets/form-BIY78yaz.js"))
    assert told == {"x-content-type-options": "nosniff", "strict-transport-security": HSTS}
    (missing,) = server.run(answered({}, path="/assets/form-gone.js", status=404))
    assert missing["content-security-policy"] == HEADERS["Content-Security-Policy"]


def test_what_a_page_says_of_itself_stands(server: ServerUnderTest) -> None:
    (told,) = server.run(answered({"Referrer-Policy": "origin"}))
    assert told["referrer-policy"] == "origin"
    assert told["x-frame-options"] == "DENY"


def test_sockets_pass_by(server: ServerUnderTest) -> None:
    assert server.run(answered({}, kind="websocket")) == [{}]


def test_a_server_started_with_a_certificate_says_so(tmp_path: Path) -> None:
    names = {"tls_cert": tmp_path / "certificate.pem", "tls_key": tmp_path / "key.pem"}
    server = ServerUnderTest(tmp_path, **names)
    assert server.get("/campus").headers["Strict-Transport-Security"] == HSTS
    server.close()
