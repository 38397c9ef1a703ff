"""Copies of video that the server refuses: kept to be looked into, but not all of them for ever."""

import asyncio
from pathlib import Path

import httpx

from contract.video import SegmentName
from vehicle_agent.link.video_uploads import REFUSED_MAX, VideoUploads


def test_the_newest_refused_copies_are_kept_and_the_others_are_sent(tmp_path: Path) -> None:
    for number in range(REFUSED_MAX + 5):
        name = SegmentName("front", number, number, 60_000)
        (tmp_path / name.text()).write_bytes(b"damaged")
    (tmp_path / SegmentName("rear", 99, 99, 60_000).text()).write_bytes(b"whole")

    def answer(request: httpx.Request) -> httpx.Response:
        return httpx.Response(201 if request.content == b"whole" else 422)

    async def upload() -> bool:
        client = httpx.AsyncClient(transport=httpx.MockTransport(answer), base_url="http://campus.test")
        return await VideoUploads("shuttle-1", tmp_path, client, lambda _: "signed").upload_waiting()

    assert asyncio.run(upload())
    left = sorted(path.name for path in tmp_path.iterdir())
    assert left == [
        SegmentName("front", number, number, 60_000).text().replace(".webm", ".refused")
        for number in range(5, REFUSED_MAX + 5)
    ]
