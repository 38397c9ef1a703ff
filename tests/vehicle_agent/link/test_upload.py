"""Run segments on their way to the server: what is tried again, and what is not."""

import asyncio
from collections.abc import Callable
from pathlib import Path

import httpx
import pytest

from contract.wire.upload import SIGNATURE_HEADER, segment_path, signed_segment
from vehicle_agent.link import upload
from vehicle_agent.link.upload import SegmentUploader

SHA256 = 64 * "a"


def uploaded(tmp_path: Path, answer: Callable[[httpx.Request], httpx.Response]) -> bool:
    """Whether nothing is left to do after one attempt."""
    segment = tmp_path / "segment.mcap"
    segment.write_bytes(b"recorded")

    async def attempt() -> bool:
        async with httpx.AsyncClient(
            transport=httpx.MockTransport(answer), base_url="http://campus.test"
        ) as client:
            uploader = SegmentUploader("shuttle-1", client, lambda text: f"signed {text.decode()}")
            return await uploader.upload(segment, SHA256)

    return asyncio.run(attempt())


@pytest.mark.parametrize(
    ("status", "done"),
    [
        (200, True),
        (201, True),
        (400, True),
        (403, True),
        (409, True),
        (408, False),
        (429, False),
        (499, True),
        (500, False),
        (503, False),
    ],
)
def test_a_server_in_trouble_is_asked_again_and_one_that_refuses_for_good_is_not(
    tmp_path: Path, status: int, done: bool
) -> None:
    assert uploaded(tmp_path, lambda _: httpx.Response(status)) is done


def test_without_a_connection_the_segment_is_kept_for_later(tmp_path: Path) -> None:
    def cut(request: httpx.Request) -> httpx.Response:
        raise httpx.ConnectError("no route", request=request)

    assert uploaded(tmp_path, cut) is False
    assert (tmp_path / "segment.mcap").read_bytes() == b"recorded"


def test_the_segment_goes_signed_to_the_address_of_its_content(tmp_path: Path) -> None:
    seen: list[httpx.Request] = []

    def note(request: httpx.Request) -> httpx.Response:
        seen.append(request)
        return httpx.Response(201)

    assert uploaded(tmp_path, note)
    (request,) = seen
    assert (request.method, request.url.path) == ("PUT", segment_path(SHA256))
    assert request.content == b"recorded"
    assert request.headers["Vehicle-Id"] == "shuttle-1"
    assert request.headers[SIGNATURE_HEADER] == f"signed {signed_segment('shuttle-1', SHA256).decode()}"


def test_a_segment_that_failed_is_tried_again_after_the_others_and_a_stored_one_is_not(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(upload, "RETRY_AFTER_S", 0.0)
    asked: list[bytes] = []
    answers = iter((503, 201, 201))

    def answer(request: httpx.Request) -> httpx.Response:
        asked.append(request.content)
        return httpx.Response(next(answers))

    async def work() -> None:
        async with httpx.AsyncClient(
            transport=httpx.MockTransport(answer), base_url="http://campus.test"
        ) as client:
            uploader = SegmentUploader("shuttle-1", client, lambda text: "signed")
            for name in ("first", "second"):
                (tmp_path / name).write_text(name)
                uploader.add(tmp_path / name, SHA256)
            running = asyncio.create_task(uploader.run())
            _, waiting = await asyncio.wait([running], timeout=0.5)
            assert waiting, "it goes on until it is cancelled"
            running.cancel()

    asyncio.run(work())
    assert asked == [b"first", b"second", b"first"]
