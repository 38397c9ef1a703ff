"""How much a region of a picture looks like a person who stands: histograms of oriented gradients (HOG).

Dalal and Triggs (2005), with OpenCV's linear classifier for people (NUS paper, section III-A).
"""

from types import ModuleType

import numpy as np

from contract.geometry import Array, IntArray

WINDOW_PX = (64, 128)
# Of the window, a person fills this much; the rest is a margin that the classifier was trained with.
PERSON_PX = 96.0
_STRIDE_PX = 8
# Lower than any score: every window is answered.
_EVERY = -1e3


class CameraLibraryMissing(Exception):
    """OpenCV is not installed, or has no people detector; the message says how to install it."""


def opencv() -> ModuleType:
    """OpenCV, which is an extra. Raises CameraLibraryMissing."""
    try:
        import cv2
    except ImportError as error:
        raise CameraLibraryMissing(
            "finding people in pictures needs OpenCV: install it with `make camera`, or "
            "`pip install opencv-contrib-python-headless`"
        ) from error
    if not hasattr(cv2, "HOGDescriptor"):
        raise CameraLibraryMissing(
            f"OpenCV {cv2.__version__} has no HOG people detector: its `contrib` build has, "
            "which `make camera` installs"
        )
    library: ModuleType = cv2
    return library


def windows_px(feet_px: Array, heights_px: Array, aside_px: int = 8, up_px: int = 16) -> IntArray:
    """(k, 4) left, top, right, bottom (excluded): what `HogPeopleDetector` reads of a picture.

    feet_px (k, 2), heights_px (k,)  the largest person that is looked for there
    """
    half = 0.5 * np.array([WINDOW_PX[0] + 2 * aside_px, WINDOW_PX[1] + 2 * up_px]) / PERSON_PX
    middle = feet_px - np.column_stack((np.zeros(len(feet_px)), 0.5 * heights_px))
    reach = heights_px[:, None] * half + 1.0
    return np.column_stack((np.floor(middle - reach), np.ceil(middle + reach))).astype(np.int64)


class HogPeopleDetector:
    """Scores regions of pictures, one thread, without a state of its own.

    aside_px, up_px  the person may stand that much beside, above and below the expected place, in pixels of
                     a person of 96 px
    """

    def __init__(self, aside_px: int = 8, up_px: int = 16) -> None:
        """Raises CameraLibraryMissing, and ValueError for what is no multiple of HOG's cell of 8 px."""
        if aside_px % _STRIDE_PX or up_px % _STRIDE_PX or min(aside_px, up_px) < 0:
            raise ValueError(f"aside_px and up_px must be multiples of {_STRIDE_PX}, not {aside_px}, {up_px}")
        self._cv2 = opencv()
        self._cv2.setNumThreads(1)
        self._hog = self._cv2.HOGDescriptor()
        self._hog.setSVMDetector(self._cv2.HOGDescriptor_getDefaultPeopleDetector())
        self._size_px = (WINDOW_PX[0] + 2 * aside_px, WINDOW_PX[1] + 2 * up_px)

    def score(self, pixels: np.ndarray, feet_px: tuple[float, float], height_px: float) -> float:
        """The score of the best window, as `best` gives it."""
        return self.best(pixels, feet_px, height_px)[0]

    def best(
        self, pixels: np.ndarray, feet_px: tuple[float, float], height_px: float
    ) -> tuple[float, tuple[float, float]]:
        """(distance from the classifier's plane, feet) of the best window; people have more than 0.

        pixels     (h, w, 3) uint8; beyond the picture its edge is repeated
        feet_px    column, row of the place on the ground between the feet
        height_px  from the feet to the top of the head
        """
        scale = PERSON_PX / height_px
        width, height = self._size_px
        # The window's middle is the person's.
        region = self._region(pixels, feet_px[0], feet_px[1] - 0.5 * height_px, scale)
        corners, scores = self._hog.detect(region, hitThreshold=_EVERY, winStride=(_STRIDE_PX, _STRIDE_PX))
        k = int(np.argmax(scores))
        aside = (float(corners[k][0]) - 0.5 * (width - WINDOW_PX[0])) / scale
        down = (float(corners[k][1]) - 0.5 * (height - WINDOW_PX[1])) / scale
        return float(np.ravel(scores)[k]), (feet_px[0] + aside, feet_px[1] + down)

    def _region(self, pixels: np.ndarray, u: float, v: float, scale: float) -> np.ndarray:
        """The surroundings of (u, v), scaled; whole pixels are cut, for a person is many of them wide."""
        width, height = (round(side / scale) for side in self._size_px)
        left, top = round(u - 0.5 * width), round(v - 0.5 * height)
        rows, columns = pixels.shape[:2]
        cut = pixels[max(0, top) : max(0, top + height), max(0, left) : max(0, left + width)]
        if not cut.size:
            return np.zeros((self._size_px[1], self._size_px[0], 3), dtype=np.uint8)
        above, before = max(0, -top), max(0, -left)
        below, after = max(0, top + height - rows), max(0, left + width - columns)
        cv2 = self._cv2
        if above or before or below or after:
            cut = cv2.copyMakeBorder(cut, above, below, before, after, borderType=cv2.BORDER_REPLICATE)
        how = cv2.INTER_AREA if scale < 1.0 else cv2.INTER_LINEAR
        scaled: np.ndarray = cv2.resize(np.ascontiguousarray(cut), self._size_px, interpolation=how)
        return scaled
