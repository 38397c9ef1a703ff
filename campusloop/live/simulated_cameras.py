"""The cameras of simulated shuttles: which there are, and the file by which the agents record them."""

NAMES = ("front", "left", "right", "rear")
WIDTH_PX, HEIGHT_PX = 320, 240
# Of each camera, where a core is left: as often as a live view shows.
RATE_HZ = 2.0
_KEEP_GIB = 2.0
_KBPS = 200


def cameras_file() -> str:
    """A vehicle's cameras.toml."""
    lines = ["# Simulated people need no blur.", f"keep_gib = {_KEEP_GIB}", 'blur = "none"']
    for name in NAMES:
        lines += [
            f"[cameras.{name}]", 'source = "ring"', f"width_px = {WIDTH_PX}", f"height_px = {HEIGHT_PX}",
            f"rate_hz = {RATE_HZ}", f"kbps = {_KBPS}",
        ]  # fmt: skip
    return "\n".join(lines) + "\n"
