"""Pictures of a fixed camera: a video file, a V4L2 device or an RTSP stream, through OpenCV."""

import re
from pathlib import Path

import numpy as np

from vehicle_agent.perception.camera.people_detector import opencv

_TIMEOUT_MS = 5000
_DEVICE = re.compile(r"(?:/dev/video)?(\d{1,3})$")


class VideoFailure(Exception):
    """The source gives no picture; the message says why and what is tried next.

    has_ended: a file was played to its end
    """

    def __init__(self, detail: str, has_ended: bool = False) -> None:
        super().__init__(detail)
        self.has_ended = has_ended


class Video:
    """One open source. Close it, or use it in a `with` statement. pictures_read: with those passed over."""

    def __init__(self, source: str) -> None:
        """source: a file, /dev/videoN or N, or a URL such as rtsp://HOST/PATH.

        Raises VideoFailure if it cannot be opened, CameraLibraryMissing without OpenCV.
        """
        cv2 = opencv()
        self._cv2, self.source = cv2, source
        device = _DEVICE.match(source)
        self.is_file = device is None and "://" not in source
        if self.is_file and not Path(source).is_file():
            raise VideoFailure(f"there is no video file {source}")
        if device is not None:
            self._capture = cv2.VideoCapture(int(device[1]), cv2.CAP_V4L2)
        elif self.is_file:
            self._capture = cv2.VideoCapture(source)
        else:
            limits = [
                cv2.CAP_PROP_OPEN_TIMEOUT_MSEC,
                _TIMEOUT_MS,
                cv2.CAP_PROP_READ_TIMEOUT_MSEC,
                _TIMEOUT_MS,
            ]
            self._capture = cv2.VideoCapture(source, cv2.CAP_FFMPEG, limits)
        if not self._capture.isOpened():
            what = (
                "is no video that OpenCV can read"
                if self.is_file
                else "cannot be opened: is it on, and reachable?"
            )
            raise VideoFailure(f"{source} {what}")
        rate_hz = float(self._capture.get(cv2.CAP_PROP_FPS))
        # Streams that do not know their rate say 0, or their clock's ticks.
        self.rate_hz = rate_hz if 0.5 <= rate_hz <= 240.0 else 25.0
        self.pictures_read = 0

    def __enter__(self) -> "Video":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def skip(self) -> None:
        """Pass over one picture. Raises VideoFailure at the end of a file, or if the source is gone."""
        if not self._capture.grab():
            raise self._failure()
        self.pictures_read += 1

    def picture(self) -> np.ndarray:
        """(h, w, 3) uint8, red green blue: the next picture. Raises VideoFailure as `skip`."""
        has_picture, pixels = self._capture.read()
        if not has_picture or pixels is None:
            raise self._failure()
        self.pictures_read += 1
        converted: np.ndarray = self._cv2.cvtColor(pixels, self._cv2.COLOR_BGR2RGB)
        return converted

    def close(self) -> None:
        self._capture.release()

    def _failure(self) -> VideoFailure:
        if not self.pictures_read:
            return VideoFailure(f"{self.source} has no picture: the file or stream is broken")
        if self.is_file:
            return VideoFailure(
                f"the video {self.source} has ended after {self.pictures_read} pictures", has_ended=True
            )
        return VideoFailure(f"{self.source} gives no more pictures")
