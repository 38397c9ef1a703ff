"""The file of a trained detector: the network as ONNX, with its record beside it."""

import hashlib
from pathlib import Path

import msgspec

from vehicle_agent.perception.pillars.grid import FEATURES, PillarGrid

# Of what goes in and comes out; a file of another version cannot be run.
VERSION = 1
DEFAULT_DETECTOR = Path(__file__).resolve().parent / "weights" / "detector.onnx"


class DetectorFileError(Exception):
    """The detector cannot be used; the message says why."""


class DetectorRecord(msgspec.Struct, frozen=True):
    """How a detector was trained, and what its file must be.

    sha256     of the ONNX file; version, features, grid: of what goes in
    trained_on, seed, scans, epochs, batch, train_cpu_min, cpu  of the training
    losses     means of each epoch
    license    of the weights
    """

    version: int
    sha256: str
    features: int
    grid: PillarGrid
    date: str
    license: str
    trained_on: str
    seed: int
    scans: int
    epochs: int
    batch: int
    train_cpu_min: float
    cpu: str
    torch: str
    losses: tuple[dict[str, float], ...]


def record_path(path: Path) -> Path:
    """The record beside an ONNX file."""
    return path.with_suffix(".json")


def read_detector_file(path: Path) -> tuple[bytes, DetectorRecord]:
    """(model, record). Raises DetectorFileError for a missing, broken or other file, or another version."""
    try:
        model, text = path.read_bytes(), record_path(path).read_bytes()
    except OSError as error:
        raise DetectorFileError(f"{error.filename or path} cannot be read: {error.strerror}") from error
    try:
        version = msgspec.json.decode(text, type=_Version).version
        if version != VERSION:
            raise DetectorFileError(
                f"{path.name} is of version {version}, and this program runs {VERSION}: train it again"
            )
        record = msgspec.json.decode(text, type=DetectorRecord)
    except msgspec.DecodeError as error:
        raise DetectorFileError(f"{record_path(path).name} is no detector's record: {error}") from error
    if record.features != FEATURES:
        raise DetectorFileError(f"{path.name} takes {record.features} features a return, not {FEATURES}")
    if hashlib.sha256(model).hexdigest() != record.sha256:
        raise DetectorFileError(f"{path.name} is not the file that its record names: it is broken or changed")
    return model, record


class _Version(msgspec.Struct, frozen=True):
    version: int
