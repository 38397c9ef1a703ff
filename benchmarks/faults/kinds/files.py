"""Files that the server needs: unreadable, exchanged, or no longer there."""

import hashlib
import shutil
import subprocess
from pathlib import Path

from benchmarks.faults.installation import free_port
from benchmarks.faults.stage import Stage, require
from contract.wire.upload import SIGNATURE_HEADER, segment_path, signed_segment

_ENDS_WITHIN_S = 90


async def certificate_unreadable(stage: Stage) -> None:
    """A server with a broken certificate must refuse to start and say what to do."""
    certificate = stage.installation.folder / "broken.pem"
    certificate.write_text("-----BEGIN CERTIFICATE-----\nnone\n-----END CERTIFICATE-----\n")
    words = _refusal(stage, ["--tls-cert", str(certificate), "--tls-key", str(certificate)])
    require("broken.pem" in words, f"the certificate is not named: {words[-300:]}")


async def ticket_key_unreadable(stage: Stage) -> None:
    """A server with a broken ticket key must refuse to start and say what to do."""
    key = stage.installation.folder / "broken.key"
    key.write_bytes(b"\x00 no key\n")
    words = _refusal(stage, [], {"CAMPUSLOOP_TICKET_KEY_FILE": str(key)})
    require("TICKET_KEY_FILE" in words, f"the setting is not named: {words[-300:]}")


async def ticket_key_exchanged(stage: Stage) -> None:
    """The server restarts with the key of another campus: it must refuse until it has its own again."""
    key = stage.installation.folder / "ticket.key"
    own = key.read_bytes()

    async def is_over() -> bool:
        return (await stage.installation.readiness()).status == 0

    async def is_refused() -> bool:
        return stage.installation.starts >= starts + 2

    key.write_bytes(b"MDEyMzQ1Njc4OTAxMjM0NTY3ODkwMTIzNDU2Nzg5MDE=\n")
    starts = stage.installation.starts
    stage.installation.kill()
    await stage.until(is_over, "the server ends")
    await stage.until(is_refused, "the server refuses the other key", 40.0)
    key.write_bytes(own)
    await stage.installation.until_ready()


async def segment_store_gone(stage: Stage) -> None:
    """The folder of run segments becomes a file: uploads are refused for the moment, and work again later."""
    folder = stage.installation.folder / "segments"
    shutil.rmtree(folder, ignore_errors=True)
    folder.write_text("no folder")
    answered = await _upload(stage, b"a segment" * 100)
    require(answered == 503, f"an upload without a store was answered with {answered}")
    folder.unlink()
    answered = await _upload(stage, b"another segment" * 100)
    require(answered < 500, f"an upload was answered with {answered} afterwards")


async def corrupt_segment(stage: Stage) -> None:
    """A recorded run is damaged on the server's disk: the viewer may show less, but no server error."""
    answered = await _upload(stage, b"\x89MCAP0\r\n" + bytes(range(256)) * 400)
    require(answered < 500, f"an upload of nonsense was answered with {answered}")
    for damaged in (stage.installation.folder / "segments").rglob("*"):
        if damaged.is_file():
            damaged.write_bytes(b"damaged")
    for run in await stage.installation.ask("GET", "/runs"):
        path = f"/runs/{run['vehicle_id']}/{run['boot_id']}"
        for what in ("", "/scenes", "/map"):
            status = (await stage.installation.http.get(path + what)).status_code
            require(status < 500, f"GET {path}{what} answered {status}")


async def _upload(stage: Stage, data: bytes) -> int:
    """The status of a signed upload by the first shuttle."""
    sha256 = hashlib.sha256(data).hexdigest()
    vehicle = stage.first
    signature = vehicle.sign(signed_segment(vehicle.vehicle_id, sha256))
    headers = {SIGNATURE_HEADER: signature, "Vehicle-Id": vehicle.vehicle_id}
    url = f"{stage.installation.origin}{segment_path(sha256)}"
    answer = await stage.installation.http.put(url, content=data, headers=headers)
    return answer.status_code


def _refusal(stage: Stage, options: list[str], variables: dict[str, str] | None = None) -> str:
    """What a second server, with a folder and a database of its own, says when it refuses to start."""
    folder = Path(stage.installation.folder, "second")
    folder.mkdir()
    environment = stage.installation.environment() | {
        "CAMPUSLOOP_VAR_DIR": str(folder),
        "CAMPUSLOOP_DATABASE_URL": "",
        **(variables or {}),
    }
    second = subprocess.run(
        [*stage.installation.command(free_port()), *options],
        env=environment,
        capture_output=True,
        text=True,
        timeout=_ENDS_WITHIN_S,
        check=False,
    )
    require(second.returncode == 2, f"it ended with {second.returncode}")
    require("Traceback" not in second.stderr, second.stderr[-300:])
    return second.stderr
