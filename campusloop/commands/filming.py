"""What `--cameras` needs."""

from vehicle_agent.runtime.video.library import is_installed


class FilmingError(Exception):
    """The shuttles' cameras cannot be simulated; the message says what to do."""


def check_cameras(has_scene: bool) -> None:
    """Raises FilmingError."""
    if not has_scene:
        raise FilmingError("--cameras needs --scene: without it there is nothing to see")
    if not is_installed():
        raise FilmingError("--cameras needs PyAV, which records them: install it with `make video`")
