"""A survey's computer sends its map to a server, is cut off, and goes on; with a token, and nothing else."""

from collections.abc import Iterator
from pathlib import Path

import httpx
import pytest

from campusloop.clients.localization_upload import UploadError, upload_localization_map
from server.domain.record.identity import Scope
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record import identity
from tests.contract.localization_folders import point_map
from tests.server.api.server_under_test import ServerUnderTest, snow_lion

HERE = snow_lion().origin


@pytest.fixture
def server(tmp_path: Path) -> Iterator[ServerUnderTest]:
    server = ServerUnderTest(tmp_path / "var")
    yield server
    server.close()


class InMemory(httpx.BaseTransport):
    """To the server in memory. cut_at: the request, from 0, at which the connection ends."""

    def __init__(self, server: ServerUnderTest, cut_at: int = -1) -> None:
        self.server, self.cut_at = server, cut_at
        self.requests = 0

    def handle_request(self, request: httpx.Request) -> httpx.Response:
        self.requests += 1
        if self.requests - 1 == self.cut_at:
            raise httpx.ReadError("cut off", request=request)
        path, headers = request.url.raw_path.decode(), dict(request.headers)
        answer = self.server.raw(request.method, path, content=request.read(), headers=headers)
        return httpx.Response(answer.status_code, headers=answer.headers, content=answer.content)


def client(server: ServerUnderTest, scope: Scope = "drive", cut_at: int = -1) -> httpx.Client:
    def work(uow: UnitOfWork) -> str:
        return identity.create_developer_token(uow, "survey", (scope,), 3600.0, "operator").secret

    secret: str = server.transact(work)
    headers = {"Authorization": f"Bearer {secret}"}
    return httpx.Client(base_url="http://campus.test", transport=InMemory(server, cut_at), headers=headers)


def upload(sender: httpx.Client, folder: Path) -> int:
    return upload_localization_map(sender, folder, "survey", lambda _done, _missing: None).sent


def test_a_map_is_sent_with_a_token_and_goes_on_after_a_cut(server: ServerUnderTest, tmp_path: Path) -> None:
    point_map(tmp_path / "map", HERE)
    with pytest.raises(httpx.ReadError):
        upload(client(server, cut_at=2), tmp_path / "map")
    assert upload(client(server), tmp_path / "map") == 2, "one tile was there already"
    assert upload(client(server), tmp_path / "map") == 0
    server.sign_in()
    (stored,) = server.get("/localization-maps").json()
    assert (stored["published_by"], stored["note"], stored["active"]) == ("developer:survey", "survey", False)


def test_what_keeps_a_map_from_being_sent_is_said(server: ServerUnderTest, tmp_path: Path) -> None:
    index = point_map(tmp_path / "map", HERE)
    with pytest.raises(UploadError, match="403"):
        upload(client(server, "read"), tmp_path / "map")
    with pytest.raises(UploadError, match="holds no localization map"):
        upload(client(server), tmp_path / "nothing")
    point_map(tmp_path / "no-gnss", None)
    with pytest.raises(UploadError, match="without GNSS"):
        upload(client(server), tmp_path / "no-gnss")
    (tmp_path / "map" / index.tiles[0].file).write_bytes(b"damaged")
    with pytest.raises(UploadError, match="hash"):
        upload(client(server), tmp_path / "map")
    (tmp_path / "map" / index.tiles[0].file).unlink()
    with pytest.raises(UploadError, match="No such file"):
        upload(client(server), tmp_path / "map")
