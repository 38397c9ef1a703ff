"""Makes the point maps that operators ask for, one after another, in a child process beside the server."""

import asyncio
import hashlib
import json
import shutil
import sys
import tempfile
import zipfile
from collections.abc import Callable
from functools import partial
from pathlib import Path

import structlog

from contract.localization_manifest import decode_manifest
from contract.scan_parcels.proposals import COMPARISON
from server.domain.fleet.scans import MapProposal
from server.store.segments.segment_store import SegmentStore, SegmentStoreError
from server.supervision.standing_tasks import PeriodicTask
from server.usecases.fleet import localization_maps, map_proposals
from server.usecases.ports import topics
from server.usecases.ports.bus import Bus
from server.usecases.ports.offload import Offload
from server.usecases.ports.scans import MapBuilder, MapBuildRefused
from server.usecases.ports.unit_of_work import Transactions, UnitOfWork

log = structlog.get_logger("loops")

PERIOD_S = 20.0
# How soon a stop is noticed, and how often the progress is stored.
BEAT_S = 1.0
_LINE_BYTES_MAX = 64 * 1024


class ProcessMapBuilder:
    """`campusloop workshop propose` as a child process: it ends when its standard input does.

    command  of the program; the server itself knows nothing of mapping
    """

    def __init__(self, command: tuple[str, ...] = (sys.executable, "-m", "campusloop")) -> None:
        self._command = command

    async def build(
        self, parcels: Path, in_force: Path | None, out: Path, tell: Callable[[str, int], None]
    ) -> None:
        options = ["--parcels", str(parcels), "--out", str(out), "--for-server"]
        if in_force is not None:
            options += ["--in-force", str(in_force)]
        child = await asyncio.create_subprocess_exec(
            *self._command,
            "workshop",
            "propose",
            *options,
            stdin=asyncio.subprocess.PIPE,
            stdout=asyncio.subprocess.PIPE,
            stderr=asyncio.subprocess.PIPE,
            limit=_LINE_BYTES_MAX,
        )
        assert child.stdout is not None
        assert child.stderr is not None
        errors = asyncio.ensure_future(child.stderr.read())
        refusal, is_done = "", False
        try:
            async for line in child.stdout:
                said = _said(line)
                if "stage" in said:
                    tell(str(said["stage"]), int(str(said.get("percent", 0))))
                refusal = str(said.get("refused", refusal))
                is_done = is_done or "done" in said
            code = await child.wait()
            trace = (await errors).decode(errors="replace").strip()
        except ValueError as error:
            raise MapBuildRefused(f"what the work said cannot be read: {error}") from error
        finally:
            # Stopped, or its output could not be read: it ends with this call.
            if child.returncode is None:
                child.kill()
                await child.wait()
            errors.cancel()
        if code == 0 and is_done:
            return
        if not refusal:
            log.error("scan_map.child_failed", code=code, trace=trace[-2000:])
            refusal = (
                f"the work ended with code {code}: {trace.splitlines()[-1] if trace else 'no reason given'}"
            )
        raise MapBuildRefused(refusal)


def _said(line: bytes) -> dict[str, object]:
    """A line of the child; what is no JSON object, as a library's warning, says nothing."""
    try:
        said = json.loads(line)
    except ValueError:
        return {}
    return said if isinstance(said, dict) else {}


class ScanMapLoop:
    """Takes what waits, and stores what becomes of it. One that is stopped meanwhile ends its child.

    scans, tiles  stores of parcels and proposals, and of localization maps' tiles
    """

    def __init__(
        self,
        transactions: Transactions,
        bus: Bus,
        campus_id: str,
        offload: Offload,
        scans: SegmentStore,
        tiles: SegmentStore,
        builder: MapBuilder,
    ) -> None:
        self._transactions = transactions
        self._offload = offload
        self._scans, self._tiles = scans, tiles
        self._builder = builder
        self.task = PeriodicTask("scan_maps", self.run_once, PERIOD_S, bus, (topics.scans(campus_id),))

    async def run_once(self) -> None:
        while True:
            proposal = await self._transactions.run(map_proposals.take_next)
            if proposal is None:
                return
            await self._make(proposal)

    async def _make(self, proposal: MapProposal) -> None:
        log.info("scan_map.begun", proposal_id=proposal.proposal_id)
        folder = Path(await self._offload.run(lambda: tempfile.mkdtemp(prefix="campusloop-scans-")))
        try:
            detail = await self._made(proposal, folder)
        except (SegmentStoreError, OSError) as error:
            detail = f"files of it cannot be read or kept now: {error}"
        finally:
            await self._offload.run(lambda: shutil.rmtree(folder, ignore_errors=True))
        if detail:
            log.warning("scan_map.failed", proposal_id=proposal.proposal_id, detail=detail)
            await self._transactions.run(
                lambda uow: map_proposals.note_failure(uow, proposal.proposal_id, detail)
            )

    async def _made(self, proposal: MapProposal, folder: Path) -> str:
        """Why it failed; "" if it did not, or was stopped. Raises SegmentStoreError, OSError."""
        in_force = await self._lay_out(proposal, folder)
        out = folder / "map"
        progress: list[tuple[str, int]] = [("", 0)]
        work = asyncio.ensure_future(
            self._builder.build(
                folder / "parcels", in_force, out, lambda stage, percent: progress.append((stage, percent))
            )
        )
        try:
            while not work.done():
                await asyncio.wait((work,), timeout=BEAT_S)
                stage, percent = progress[-1]
                del progress[:-1]
                note = partial(
                    map_proposals.note_progress,
                    proposal_id=proposal.proposal_id,
                    stage=stage,
                    percent=percent,
                )
                if not await self._transactions.run(note):
                    log.info("scan_map.stopped", proposal_id=proposal.proposal_id)
                    return ""
            work.result()
        except MapBuildRefused as refusal:
            return str(refusal)
        finally:
            work.cancel()
            await asyncio.gather(work, return_exceptions=True)
        sha256, comparison = await self._offload.run(lambda: self._keep(proposal.proposal_id, out, folder))
        await self._transactions.run(
            lambda uow: map_proposals.note_result(uow, proposal.proposal_id, sha256, comparison)
        )
        log.info("scan_map.ready", proposal_id=proposal.proposal_id)
        return ""

    async def _lay_out(self, proposal: MapProposal, folder: Path) -> Path | None:
        """Parcels, and the map in force, as files for the child; the folder of that map, None without one."""

        def read(uow: UnitOfWork) -> tuple[tuple[str, ...], bytes | None]:
            hashes = tuple(one.sha256 for one in uow.scans.parcels(proposal.request_id))
            in_force = uow.localization_maps.in_force().get("points")
            if in_force is None:
                return hashes, None
            return hashes, localization_maps.manifest_of(uow, in_force.map_version)

        hashes, manifest = await self._transactions.read(read)
        await self._offload.run(lambda: self._copy_parcels(hashes, folder / "parcels"))
        if manifest is None:
            return None
        await self._offload.run(lambda: self._copy_map(manifest, folder / "in-force"))
        return folder / "in-force"

    def _copy_parcels(self, hashes: tuple[str, ...], folder: Path) -> None:
        folder.mkdir()
        for sha256 in hashes:
            path = self._scans.fetch(sha256)
            # One that is lost is as one that never came: the others make the map.
            if path is not None:
                shutil.copyfile(path, folder / f"{sha256}.zip")

    def _copy_map(self, manifest: bytes, folder: Path) -> None:
        folder.mkdir()
        for tile in decode_manifest(manifest).tiles:
            path = self._tiles.fetch(tile.sha256)
            if path is None:
                raise FileNotFoundError(f"tile {tile.sha256} of the map in force is not kept")
            (folder / tile.file).parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(path, folder / tile.file)
        (folder / "index.json").write_bytes(manifest)

    def _keep(self, proposal_id: str, out: Path, folder: Path) -> tuple[str, bytes]:
        """(hash of the ZIP file in the store, the figures)."""
        comparison = (out / COMPARISON).read_bytes()
        packed = folder / "result.zip"
        # Tiles and pictures are compressed already.
        with zipfile.ZipFile(packed, "w", zipfile.ZIP_STORED) as file:
            for path in sorted(one for one in out.rglob("*") if one.is_file()):
                file.write(path, str(path.relative_to(out)))
        data = packed.read_bytes()
        sha256 = hashlib.sha256(data).hexdigest()
        with self._scans.receive(sha256, proposal_id) as incoming:
            incoming.write(data)
            incoming.prove()
            self._scans.keep(incoming)
        return sha256, comparison
