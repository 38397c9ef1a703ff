"""Parcels go up once, wait while the server is away, and what goes wrong is said once to the server."""

import asyncio
import hashlib
from collections.abc import Callable
from pathlib import Path

import httpx
import pytest

from contract.wire.messages import ScanArea, ScansReported, ScansRequested
from contract.wire.scans import signed_parcel
from vehicle_agent.link import scan_uploads
from vehicle_agent.link.scan_uploads import ScanUploads

AREA = ScanArea("scans-1", (), 0.5, 1 << 40, 1 << 62)


class Server:
    def __init__(self) -> None:
        self.status = 201
        self.taken: list[bytes] = []
        self.asked = 0

    def __call__(self, request: httpx.Request) -> httpx.Response:
        self.asked += 1
        if self.status == 0:
            raise httpx.ConnectError("no route to host")
        sha256 = request.url.path.rsplit("/", 1)[1]
        assert hashlib.sha256(request.content).hexdigest() == sha256
        signature = request.headers["Vehicle-Signature"]
        assert signature == signed_parcel("shuttle-1", sha256).decode().replace("\n", " ")
        if self.status < 300:
            self.taken.append(request.content)
        return httpx.Response(self.status, text="because")


class Uploading:
    def __init__(self, folder: Path, server: Server) -> None:
        self.said: list[ScansReported] = []
        self.told: list[tuple[ScanArea, ...]] = []
        self.folder = folder
        client = httpx.AsyncClient(base_url="http://campus.test", transport=httpx.MockTransport(server))
        self.uploads = ScanUploads(
            "shuttle-1", folder, client, lambda text: text.decode().replace("\n", " "), self._report,
            self.told.append, retry_after_s=0.02,
        )  # fmt: skip

    async def _report(self, report: ScansReported) -> None:
        self.said.append(report)

    def parcel(self, content: bytes = b"scans") -> Path:
        path = self.folder / "scans-1" / f"{hashlib.sha256(content).hexdigest()}.zip"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content)
        return path

    def keeps(self, **changes: object) -> None:
        values: dict[str, object] = {"state": "collecting", "scans": 8, "way_m": 4.0, "bytes_kept": 5}
        self.uploads.kept((ScansReported("scans-1", **(values | changes)),))  # type: ignore[arg-type]

    async def until(self, is_so: Callable[[], bool]) -> None:
        task = asyncio.ensure_future(self.uploads.run())
        async with asyncio.timeout(5.0):
            while not is_so():
                assert not task.done(), task.exception()
                await asyncio.sleep(0.005)
        task.cancel()
        await asyncio.gather(task, return_exceptions=True)


@pytest.fixture(autouse=True)
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(scan_uploads, "LOOK_S", 0.01)


def test_a_parcel_is_sent_signed_and_then_removed(tmp_path: Path) -> None:
    async def drive() -> None:
        server = Server()
        one = Uploading(tmp_path, server)
        one.uploads.requested(ScansRequested(1, (AREA,)))
        one.keeps()
        path = one.parcel()
        await one.until(lambda: not path.exists() and bool(one.said))
        assert server.taken == [b"scans"]
        assert [report.state for report in one.said] == ["collecting"]
        assert one.told[0] == (AREA,)

    asyncio.run(drive())


def test_a_server_that_is_away_is_told_once_and_the_parcel_waits(tmp_path: Path) -> None:
    async def drive() -> None:
        server = Server()
        one = Uploading(tmp_path, server)
        one.uploads.requested(ScansRequested(1, (AREA,)))
        one.keeps()
        path = one.parcel()
        for status in (0, 503):
            server.status, server.asked = status, 0
            await one.until(lambda: server.asked >= 3)
            assert path.exists()
        assert [report.state for report in one.said] == ["not_uploaded", "not_uploaded"]
        assert "cannot be reached" in one.said[0].detail
        assert "503: because" in one.said[1].detail
        server.status = 201
        await one.until(lambda: one.said[-1].state == "collecting")
        assert server.taken == [b"scans"]

    asyncio.run(drive())


def test_a_refused_parcel_is_kept_aside_and_the_others_go_on(tmp_path: Path) -> None:
    async def drive() -> None:
        server = Server()
        server.status = 409
        one = Uploading(tmp_path, server)
        one.uploads.requested(ScansRequested(1, (AREA,)))
        one.keeps()
        path = one.parcel()
        await one.until(lambda: bool(one.said) and not path.exists())
        assert one.said[-1].state == "not_uploaded"
        assert "refused: because" in one.said[-1].detail
        assert path.with_suffix(".refused").read_bytes() == b"scans"
        server.status = 201
        other = one.parcel(b"more")
        await one.until(lambda: not other.exists())
        one.uploads.requested(ScansRequested(1, ()))
        one.keeps(state="ended")
        await one.until(lambda: one.said[-1].state == "ended")

    asyncio.run(drive())
    assert not list(tmp_path.glob("*/*"))


def test_an_ended_request_is_ended_once_all_of_it_has_come(tmp_path: Path) -> None:
    async def drive() -> None:
        server = Server()
        server.status = 503
        one = Uploading(tmp_path, server)
        one.uploads.requested(ScansRequested(1, (AREA,)))
        one.keeps()
        path = one.parcel()
        await one.until(lambda: bool(one.said))
        one.uploads.requested(ScansRequested(1, ()))
        one.keeps(state="ended", scans=9)
        asked = server.asked
        await one.until(lambda: server.asked > asked + 2)
        assert one.said[-1].state == "not_uploaded"
        server.status = 200
        await one.until(lambda: one.said[-1].state == "ended")
        assert not path.exists()
        assert one.said[-1].scans == 9

    asyncio.run(drive())


def test_a_keeping_process_that_says_nothing_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(scan_uploads, "SILENT_S", 0.05)

    async def drive() -> None:
        one = Uploading(tmp_path, Server())
        one.uploads.requested(ScansRequested(1, (AREA,)))
        await one.until(lambda: bool(one.said) and one.said[-1].state == "keeper_silent")
        one.keeps(state="waiting")
        monkeypatch.setattr(scan_uploads, "SILENT_S", 60.0)
        await one.until(lambda: one.said[-1].state == "waiting")

    asyncio.run(drive())


def test_a_parcel_that_cannot_be_read_is_said_and_keeps_up_neither_others_nor_the_link(
    tmp_path: Path,
) -> None:
    async def scenario() -> None:
        server = Server()
        uploading = Uploading(tmp_path, server)
        uploading.uploads.requested(ScansRequested(1, (AREA,)))
        (tmp_path / "scans-1" / "0.zip").mkdir(parents=True)
        good = uploading.parcel()
        uploading.keeps()
        await uploading.until(lambda: not good.exists() and "cannot be read" in str(uploading.said))
        assert server.taken == [b"scans"]

    asyncio.run(scenario())


def test_a_folder_that_cannot_be_looked_into_is_looked_into_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    async def scenario() -> None:
        server, looks = Server(), [0]
        uploading = Uploading(tmp_path, server)
        good, look = uploading.parcel(), uploading.uploads._waiting

        def broken_once() -> list[Path]:
            looks[0] += 1
            if looks[0] == 1:
                raise OSError("input/output error")
            return look()

        monkeypatch.setattr(uploading.uploads, "_waiting", broken_once)
        await uploading.until(lambda: not good.exists())
        assert server.taken == [b"scans"]

    asyncio.run(scenario())
