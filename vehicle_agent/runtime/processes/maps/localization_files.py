"""The localization maps in a vehicle's folder: the one in force, the one before, one on its way.

localization-maps/in-force       the version in force and the one before it, a line each; replaced as a whole
localization-maps/VERSION/       a whole map, as `contract/point_map` or `contract/occupancy` has it
localization-maps/.VERSION.part/ what has come of one; a fetch that was cut off goes on there
point-map/                       a map that was given by hand, in force while `in-force` names none
"""

import hashlib
import os
import shutil
from pathlib import Path

from contract.localization_manifest import LocalizationManifest, TileFile, decode_manifest
from contract.localization_maps import LocalizationMapError

INDEX, IN_FORCE = "index.json", "in-force"
# The outbox and run logs need room too: a map is not fetched into the last of it.
RESERVE_BYTES = 200 << 20


class LocalizationFiles:
    """One vehicle's. The link fetches and prunes, the tick adopts; neither removes what the other needs."""

    def __init__(self, root: Path, reserve_bytes: int = RESERVE_BYTES) -> None:
        self.root = root / "localization-maps"
        self.by_hand = root / "point-map"
        self._reserve_bytes = reserve_bytes

    def in_force(self) -> Path | None:
        """The folder of the map that scans are compared with; None for a vehicle that has none."""
        version = self._versions()[0]
        if version and (self.root / version / INDEX).exists():
            return self.root / version
        return self.by_hand if (self.by_hand / INDEX).exists() else None

    def is_fetched(self) -> bool:
        """The map in force came from the server, and can come again."""
        folder = self.in_force()
        return folder is not None and folder != self.by_hand

    def has(self, map_version: str) -> bool:
        """It lies here whole, e.g. for a roll back."""
        return (self.root / map_version / INDEX).exists()

    def begin(self, manifest: LocalizationManifest, data: bytes) -> tuple[Path, tuple[TileFile, ...]]:
        """(folder to fetch into, tiles that must be fetched): those that another map has here are taken over.

        data  of the manifest. Raises OSError, also for a disk that would have too little room left; then no
        part of the map is left.
        """
        part = self.root / f".{manifest.map_version}.part"
        try:
            return part, self._begin(part, manifest, data)
        except OSError:
            self.give_up(part)
            raise

    def _begin(self, part: Path, manifest: LocalizationManifest, data: bytes) -> tuple[TileFile, ...]:
        (part / "tiles").mkdir(parents=True, exist_ok=True)
        known = self._known_tiles(part)
        missing = []
        for tile in manifest.tiles:
            path = part / tile.file
            if not _is(path, tile) and not _took_over(known.get(tile.sha256), path, tile):
                missing.append(tile)
        needed = sum(tile.bytes for tile in missing)
        free = shutil.disk_usage(part).free
        if needed + self._reserve_bytes > free:
            raise OSError(
                f"{needed} bytes are missing and {free} are free, of which {self._reserve_bytes} stay free"
            )
        _write(part / f"{INDEX}.wanted", data)
        return tuple(missing)

    def save_tile(self, part: Path, tile: TileFile, data: bytes) -> None:
        """Whole or not at all. Raises OSError."""
        fresh = part / f"{tile.file}.new"
        try:
            _write(fresh, data)
            fresh.replace(part / tile.file)
        except OSError:
            fresh.unlink(missing_ok=True)
            raise

    def seal(self, part: Path) -> None:
        """The folder in `part` has all its tiles: from now on it has an index too. Raises OSError."""
        (part / f"{INDEX}.wanted").replace(part / INDEX)

    def complete(self, part: Path, map_version: str) -> None:
        """The sealed and checked map lies ready. Raises OSError."""
        target = self.root / map_version
        shutil.rmtree(target, ignore_errors=True)
        part.rename(target)
        _sync(self.root)

    def give_up(self, part: Path) -> None:
        """Removes what has come, e.g. to give a full disk its room back."""
        shutil.rmtree(part, ignore_errors=True)

    def adopt(self, map_version: str) -> None:
        """From now on it is in force. Writes some bytes. Raises OSError; then the one before stays."""
        before, earlier = self._versions()
        previous = earlier if before == map_version else before
        fresh = self.root / f"{IN_FORCE}.new"
        _write(fresh, f"{map_version}\n{previous}\n".encode())
        fresh.replace(self.root / IN_FORCE)
        _sync(self.root)

    def discard_in_force(self) -> None:
        """A fetched map is damaged: the server sends it again. What was given by hand counts meanwhile."""
        version = self._versions()[0]
        (self.root / IN_FORCE).unlink(missing_ok=True)
        if version:
            shutil.rmtree(self.root / version, ignore_errors=True)

    def forget(self) -> None:
        """Another map is given by hand: it counts, until the server announces one."""
        (self.root / IN_FORCE).unlink(missing_ok=True)

    def prune(self, wanted: str) -> None:
        """Removes all maps but the one in force, the one before it, and what is wanted."""
        kept = {*self._versions(), wanted, f".{wanted}.part"}
        for folder in self.root.glob("*"):
            if folder.is_dir() and folder.name not in kept:
                shutil.rmtree(folder, ignore_errors=True)

    def _versions(self) -> tuple[str, str]:
        """(in force, the one before), "" for none."""
        try:
            lines = (self.root / IN_FORCE).read_text().splitlines()
        except FileNotFoundError:
            return "", ""
        in_force, previous = [*lines, "", ""][:2]
        return in_force, previous

    def _known_tiles(self, part: Path) -> dict[str, Path]:
        """Tiles of all whole maps here, by SHA-256; their bytes are checked when one is taken over."""
        known: dict[str, Path] = {}
        for index in (*self.root.glob(f"*/{INDEX}"), self.by_hand / INDEX):
            if index.parent == part or not index.exists():
                continue
            try:
                tiles = decode_manifest(index.read_bytes()).tiles
            except LocalizationMapError:
                continue  # one that cannot be read has nothing to give
            known |= {tile.sha256: index.parent / tile.file for tile in tiles}
        return known


def _took_over(source: Path | None, path: Path, tile: TileFile) -> bool:
    if source is None or not _is(source, tile):
        return False
    path.unlink(missing_ok=True)
    try:
        os.link(source, path)
    except OSError:  # a disk without links
        shutil.copyfile(source, path)
    return _is(path, tile)


def _is(path: Path, tile: TileFile) -> bool:
    try:
        data = path.read_bytes()
    except OSError:
        return False
    return len(data) == tile.bytes and hashlib.sha256(data).hexdigest() == tile.sha256


def _write(path: Path, data: bytes) -> None:
    """On the disk, or an OSError."""
    with path.open("wb") as file:
        file.write(data)
        file.flush()
        os.fsync(file.fileno())


def _sync(folder: Path) -> None:
    number = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(number)
    finally:
        os.close(number)
