"""How many people are in an observation area, by the pictures of a fixed camera."""

from dataclasses import dataclass

import numpy as np

from campusloop.crossing_cameras.ground_pixels import GroundPixels
from contract.geometry import Array
from contract.roads.areas import inside
from vehicle_agent.perception.camera.people_detector import HogPeopleDetector, opencv


@dataclass(frozen=True, slots=True)
class CounterParams:
    """score_person     HOG score of a region by which it shows a person
    score_moving     enough for a thing that moves and has a person's height
    person_ratio     height of a moving thing, of a person's at its place, from and to
    apart_ratio      two regions nearer than this, of a person's height aside and along, show one person
    apart_m          the same on the ground, from one picture to the next
    grid_m           the area is looked at in such steps, too, for people who stand
    grid_places      so many of these places in each picture, one after another
    keep_pictures    a person whom the pictures lose stays counted for so many
    height_px_min    smaller people are not told from noise
    """

    score_person: float = 0.0
    score_moving: float = -0.8
    person_ratio: tuple[float, float] = (0.5, 1.4)
    apart_ratio: tuple[float, float] = (0.22, 0.35)
    apart_m: float = 0.5
    grid_m: float = 0.4
    grid_places: int = 30
    keep_pictures: int = 3
    height_px_min: float = 16.0


class PeopleCounter:
    """Counts picture after picture: what moves is found by the background, people among it by HOG."""

    def __init__(self, ground: GroundPixels, outline_map: Array, params: CounterParams | None = None) -> None:
        """outline_map (n, 2): of the area. Raises CameraLibraryMissing."""
        self._ground, self._outline = ground, np.asarray(outline_map, dtype=np.float64)
        self.params = params or CounterParams()
        self._cv2 = opencv()
        self._detector = HogPeopleDetector(8, 8)
        self._background = self._cv2.createBackgroundSubtractorMOG2(
            history=300, varThreshold=25, detectShadows=True
        )
        self._grid = self._places_of_area()
        self._pictures = 0
        # Rows: x, y of a person, picture of the last sight.
        self._known: Array = np.empty((0, 3))

    def count(self, pixels: np.ndarray) -> int:
        """People in the area in this picture (h, w, 3) uint8; pictures are given in order."""
        places = self.people(pixels)
        return int(np.count_nonzero(inside(self._outline, places))) if len(places) else 0

    def people(self, pixels: np.ndarray) -> Array:
        """(n, 2) where the people stand, map frame; those near to the area among them."""
        params = self.params
        groups = (
            (self._moving_places(self._background.apply(pixels)), params.score_moving),
            (self._known[:, :2], params.score_person),
            (self._next_grid_places(), params.score_person),
        )
        places = np.concatenate([group for group, _ in groups])
        limits = np.concatenate([np.full(len(group), limit) for group, limit in groups])
        self._remember(self._verified(pixels, places, limits))
        self._pictures += 1
        return self._known[:, :2].copy()

    def _next_grid_places(self) -> Array:
        count = min(self.params.grid_places, len(self._grid))
        return np.roll(self._grid, -self._pictures * count, axis=0)[:count]

    def _verified(self, pixels: np.ndarray, places: Array, limits: Array) -> Array:
        """(k, 2) where the people of these places stand, each person once."""
        if not len(places):
            return places.reshape(0, 2)
        feet, heights = self._ground.pixels(places), self._ground.person_heights_px(places)
        rows, columns = pixels.shape[:2]
        usable = np.isfinite(feet).all(axis=1) & (heights >= self.params.height_px_min)
        usable &= (feet[:, 0] > 0.0) & (feet[:, 0] < columns) & (feet[:, 1] < rows + 0.1 * heights)
        usable &= feet[:, 1] - heights > -0.2 * heights
        scores = np.full(len(places), -np.inf)
        for k in np.flatnonzero(usable).tolist():
            at = (float(feet[k, 0]), float(feet[k, 1]))
            # The next size is only tried where the first says something.
            score, found = self._detector.best(pixels, at, float(heights[k]))
            if -1.0 < score < 1.0:
                score, found = max((score, found), self._detector.best(pixels, at, 1.12 * float(heights[k])))
            scores[k], feet[k] = score, found
        kept = self._once(feet, heights, scores, scores >= limits)
        return self._ground.places(feet[kept])

    def _once(self, feet: Array, heights: Array, scores: Array, chosen: np.ndarray) -> list[int]:
        """Rows of different people, the surest first."""
        aside, along = self.params.apart_ratio
        kept: list[int] = []
        for k in np.argsort(-scores, kind="stable").tolist():
            if not chosen[k]:
                continue
            apart = np.abs(feet[kept] - feet[k]) / heights[k]
            if not np.any((apart[:, 0] < aside) & (apart[:, 1] < along)):
                kept.append(k)
        return kept

    def _moving_places(self, moving: np.ndarray) -> Array:
        """(n, 2) where things that move touch the ground; a wide one, such as a group, at several places."""
        cv2 = self._cv2
        mask = cv2.morphologyEx((moving == 255).astype(np.uint8), cv2.MORPH_OPEN, np.ones((2, 2), np.uint8))
        mask = cv2.morphologyEx(mask, cv2.MORPH_CLOSE, np.ones((9, 5), np.uint8))
        _, _, boxes, _ = cv2.connectedComponentsWithStats(mask)
        found = []
        for left, top, width, height, size in boxes[1:].tolist():
            foot = np.array([[left + 0.5 * width, top + height - 1.0]])
            place = self._ground.places(foot)
            expected = float(self._ground.person_heights_px(place)[0])
            low, high = self.params.person_ratio
            if not (np.isfinite(expected) and expected >= self.params.height_px_min):
                continue
            if size < 0.04 * expected**2 or not low * expected <= height <= high * expected:
                continue
            if np.min(np.linalg.norm(self._grid - place, axis=1), initial=np.inf) > 3.0:
                continue
            beside = max(1, round(width / (0.35 * expected)))
            columns = left + width * (np.arange(beside) + 0.5) / beside
            found.append(self._ground.places(np.column_stack((columns, np.full(beside, foot[0, 1])))))
        return np.concatenate(found) if found else np.empty((0, 2))

    def _remember(self, found: Array) -> None:
        """People who were found now, and those of the last pictures who were not found elsewhere."""
        now = np.column_stack((found, np.full(len(found), float(self._pictures))))
        fresh = self._known[self._pictures - self._known[:, 2] <= self.params.keep_pictures]
        lost = [
            row for row in fresh
            if all(np.hypot(*(row[:2] - place)) >= 2.0 * self.params.apart_m for place in found)
        ]  # fmt: skip
        self._known = np.vstack((now, np.array(lost).reshape(-1, 3)))

    def _places_of_area(self) -> Array:
        low, high = self._outline.min(axis=0), self._outline.max(axis=0)
        step = self.params.grid_m
        x, y = np.meshgrid(np.arange(low[0], high[0] + step, step), np.arange(low[1], high[1] + step, step))
        places = np.column_stack((x.ravel(), y.ravel()))
        return places[inside(self._outline, places)]
