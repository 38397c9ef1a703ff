"""`campusloop workshop train-detector`: trains the detector on simulated scans."""

import platform
from pathlib import Path
from typing import Annotated, NoReturn

import typer
from rich.console import Console
from rich.markup import escape

from campusloop.commands.workshop.bars import StageBars, stage_bars
from campusloop.commands.workshop.site_maps import make_parent
from campusloop.kernels.compiling import ensure_kernels
from campusloop.kernels.groups import DETECTOR, SIMULATOR

console = Console(soft_wrap=True)

EXIT_BAD_INPUT = 2
EXIT_NOT_WRITTEN = 3
EXIT_STOPPED = 130
# Scans that say after each epoch how well others than those learned from are answered.
_TUNING_SCANS = 24
_NEEDS = "training needs PyTorch and onnx: run `make training`, or `pip install torch onnx`"


def train_detector(
    out: Annotated[Path, typer.Option(help="The detector's ONNX file; its record is written beside it.")],
    seed: Annotated[int, typer.Option(min=0, help="Of scenes and training.")] = 1,
    scenes: Annotated[int, typer.Option(min=8, help="Scans to learn from.")] = 1200,
    epochs: Annotated[int, typer.Option(min=1, help="Times that each scan is seen.")] = 32,
    work: Annotated[
        Path | None, typer.Option(help="Folder for scans and checkpoint; var/detector without it.")
    ] = None,
) -> None:
    """Make simulated scans and train the detector on them; after Ctrl-C the same command goes on."""
    try:
        import onnx  # noqa: F401
        import torch  # noqa: F401
    except ImportError:
        _refuse(_NEEDS)
    from campusloop.scenes.detector_scenes.folder import make_scans
    from contract.roads.load import MapError
    from simulator.sensors.scene.changes import SceneError
    from vehicle_agent.perception.pillars.grid import PillarGrid, pillars_of
    from workshop.detector.export import ExportError, exported, write_detector
    from workshop.detector.labeled_scans import ScanFileError, read_scan
    from workshop.detector.training import CheckpointError, train
    from workshop.detector.training_params import TrainingParams

    make_parent(out)
    ensure_kernels((*SIMULATOR, *DETECTOR))
    folder = (work or Path("var") / "detector") / f"seed-{seed}"
    params, grid = TrainingParams(epochs=epochs, seed=seed), PillarGrid()
    try:
        with stage_bars(console) as bars:
            stage = StageBars(bars)
            stage.begin("scans to learn from", scenes)
            learned = make_scans(folder / "scans", "train", seed, scenes, stage.advance)
            stage.begin("scans for tuning", _TUNING_SCANS)
            tuning = make_scans(folder / "scans", "tune", seed, _TUNING_SCANS, stage.advance)
            stage.begin("steps of training", epochs * (scenes // params.batch))
            checkpoint = folder / f"checkpoint-{scenes}-{epochs}.pt"
            state = train(learned, tuning, grid, params, checkpoint, lambda steps, _: stage.advance(steps))
        scans = [read_scan(path) for path in tuning[:4]]
        samples = [pillars_of(scan.points, scan.is_older, grid) for scan in scans]
        trained_on = f"{scenes} simulated scans of the shipped campuses, split `train`"
        record = write_detector(
            out, exported(state.network, samples), state, params, scenes, trained_on, _cpu()
        )
    except KeyboardInterrupt as stopped:
        console.print("stopped; the same command goes on from the last whole epoch")
        raise typer.Exit(EXIT_STOPPED) from stopped
    except (CheckpointError, ScanFileError, MapError, SceneError) as error:
        _refuse(str(error))
    except (ExportError, OSError) as error:
        console.print(f"[red]{escape(f'{out} cannot be written: {error}')}[/red]", highlight=False)
        raise typer.Exit(EXIT_NOT_WRITTEN) from error
    last = {name: round(value, 3) for name, value in record.losses[-1].items()}
    console.print(f"{record.train_cpu_min:.1f} min of CPU; losses {last}", highlight=False)
    console.print(f"written: {out}, sha256 {record.sha256}", highlight=False)


def _cpu() -> str:
    """The processor's name, without which minutes cannot be compared."""
    info = Path("/proc/cpuinfo")
    lines = info.read_text(encoding="utf-8", errors="replace").splitlines() if info.exists() else []
    names = [line.partition(":")[2].strip() for line in lines if line.lower().startswith("model name")]
    return names[0] if names else platform.processor() or platform.machine()


def _refuse(detail: str) -> NoReturn:
    console.print(f"[red]{escape(detail)}[/red]", highlight=False)
    raise typer.Exit(EXIT_BAD_INPUT)
