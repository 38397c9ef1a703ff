"""Where a place of the campus lies on the canvas of a map that shows all of it."""

from collections.abc import Sequence

from playwright.sync_api import Locator

from contract.roads.network import RoadNetwork

# As web/src/shared/map/map_view.ts fits the campus into its canvas.
TOP_PX, RIGHT_PX, BOTTOM_PX, LEFT_PX = 32.0, 88.0, 40.0, 36.0

Place = Sequence[float]


def click_road(canvas: Locator, network: RoadNetwork, lane_id: str) -> None:
    """Click in the middle of a lane."""
    line = network.lines[lane_id]
    x_m, y_m, *_ = network.pose(lane_id, line.length_m / 2)
    ends = [line.points[end] for line in network.lines.values() for end in (0, -1)]
    canvas.scroll_into_view_if_needed()
    x_px, y_px = place_px(canvas, ends, (float(x_m), float(y_m)))
    canvas.click(position={"x": x_px, "y": y_px})


def place_px(canvas: Locator, ends: Sequence[Place], at: Place) -> tuple[float, float]:
    """A place of the map, from the canvas's upper left corner. ends: those of all lanes."""
    x_min, x_max = min(float(x) for x, _ in ends), max(float(x) for x, _ in ends)
    y_min, y_max = min(float(y) for _, y in ends), max(float(y) for _, y in ends)
    box = canvas.bounding_box()
    assert box is not None
    free_width, free_height = box["width"] - LEFT_PX - RIGHT_PX, box["height"] - TOP_PX - BOTTOM_PX
    px_per_m = min(free_width / (x_max - x_min), free_height / (y_max - y_min))
    centre_x = (x_min + x_max) / 2 - (LEFT_PX - RIGHT_PX) / 2 / px_per_m
    centre_y = (y_min + y_max) / 2 + (TOP_PX - BOTTOM_PX) / 2 / px_per_m
    return (
        box["width"] / 2 + (at[0] - centre_x) * px_per_m,
        box["height"] / 2 - (at[1] - centre_y) * px_per_m,
    )
