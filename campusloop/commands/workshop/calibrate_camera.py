"""`campusloop workshop calibrate-camera`: the lens of a camera, from pictures of a chessboard."""

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from vehicle_agent.perception.camera.people_detector import CameraLibraryMissing
from workshop.calibration.lens import LensPicturesError, lens_of

console = Console()

EXIT_BAD_INPUT = 2
_PICTURES = {".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff"}


def calibrate_camera(
    folder: Annotated[
        Path,
        typer.Argument(help="Folder of pictures (PNG, JPEG, BMP, TIFF) of the whole board."),
    ],
    board: Annotated[str, typer.Option(help="Inner corners of the board, COLUMNSxROWS.")] = "9x6",
    square_mm: Annotated[float, typer.Option(min=1.0, help="Side of one square, mm.")] = 25.0,
    out: Annotated[Path, typer.Option(help="File to write the lens to (TOML), never overwritten.")] = Path(
        "camera.toml"
    ),
) -> None:
    """Measure a camera's lens, for `calibration` in a vehicle's cameras.toml."""
    try:
        if out.exists():
            raise LensPicturesError(f"{out} is there already; name another file with --out")
        pictures = sorted(path for path in folder.glob("*") if path.suffix.lower() in _PICTURES)
        if not pictures:
            raise LensPicturesError(f"{folder} has no pictures ({', '.join(sorted(_PICTURES))})")
        found = lens_of(pictures, *_corners(board), 1e-3 * square_mm)
        out.write_text(found.lens.toml())
    except (LensPicturesError, CameraLibraryMissing, OSError) as error:
        console.print(f"[red]{escape(str(error))}[/red]", soft_wrap=True, highlight=False)
        raise typer.Exit(EXIT_BAD_INPUT) from error
    table = Table("picture", "corners off (px)")
    for name, off_px in found.rms_px.items():
        table.add_row(name, "no whole board" if off_px is None else f"{off_px:.3f}")
    console.print(table)
    lens = found.lens
    console.print(
        f"{lens.width_px} x {lens.height_px} px, focal lengths {lens.fx_px:.1f} and {lens.fy_px:.1f} px, "
        f"corners {lens.rms_px:.3f} px off, the board in {100 * found.reach[0]:.0f} % of the width and "
        f"{100 * found.reach[1]:.0f} % of the height; written to {out}",
        soft_wrap=True,
        highlight=False,
    )


def _corners(board: str) -> tuple[int, int]:
    """Columns and rows. Raises LensPicturesError."""
    columns, x, rows = board.partition("x")
    if not (x and columns.isdecimal() and rows.isdecimal() and int(columns) > 2 and int(rows) > 2):
        raise LensPicturesError(f"{board!r} is no board; give COLUMNSxROWS of its inner corners, such as 9x6")
    return int(columns), int(rows)
