"""`campusloop warm`: compile numba kernels into the cache, so that no live process waits for the compiler."""

from typing import Annotated

import typer
from rich.console import Console
from rich.markup import escape

from campusloop.kernels.caches import CachesNotWritable
from campusloop.kernels.compiling import KernelError, compile_kernels
from campusloop.kernels.groups import EVERYTHING, GROUPS

EXIT_FAILED = 1
EXIT_BAD_INPUT = 2


def warm(
    groups: Annotated[list[str] | None, typer.Argument(help=f"Of {', '.join(GROUPS)}; default: all.")] = None,
) -> None:
    """Compile the numerical kernels that are not compiled yet."""
    console = Console(soft_wrap=True)
    named = tuple(groups or EVERYTHING)
    unknown = [name for name in named if name not in GROUPS]
    if unknown:
        console.print(f"[red]no kernels are called {', '.join(unknown)}[/red]; there are {', '.join(GROUPS)}")
        raise typer.Exit(EXIT_BAD_INPUT)
    try:
        compile_kernels(named, console)
    except (KernelError, CachesNotWritable) as error:
        console.print(f"[red]{escape(str(error))}[/red]", highlight=False)
        raise typer.Exit(EXIT_FAILED) from error
