"""Pictures so coarse that no face and no plate can be read in them, made before a segment leaves the vehicle.

No detector of faces is trusted with that: the libraries here have none, and one that finds 95 % shows every
twentieth. A block of 20 pixels is wider than a plate's letters from 1 m on, and half of a face from 3 m on.
"""

from fractions import Fraction
from pathlib import Path

from vehicle_agent.runtime.video.library import pyav

BLOCK_PX = 20
_KBPS = 100


def coarsened(source: Path, to: Path) -> bool:
    """Writes the segment with the same times in blocks of BLOCK_PX; False if it cannot be read to its end.

    Raises OSError.
    """
    av = pyav()
    try:
        with av.open(str(source)) as read, av.open(str(to), "w", format="webm") as written:
            video = read.streams.video[0]
            stream = written.add_stream("libvpx", rate=Fraction(10))
            width, height = video.codec_context.width, video.codec_context.height
            stream.width, stream.height, stream.pix_fmt = width, height, "yuv420p"
            stream.bit_rate, stream.gop_size = _KBPS * 1000, 10
            stream.options = {"deadline": "realtime", "cpu-used": "16", "lag-in-frames": "0"}
            stream.codec_context.time_base, stream.codec_context.thread_count = Fraction(1, 1000), 1
            small = (max(2, width // BLOCK_PX), max(2, height // BLOCK_PX))
            to_small, to_wide = (av.video.reformatter.VideoReformatter() for _ in range(2))
            for frame in read.decode(video):
                coarse = to_small.reformat(frame, *small, "yuv420p", interpolation="AREA")
                wide = to_wide.reformat(coarse, width, height, interpolation="BILINEAR")
                wide.pts, wide.time_base = frame.pts, frame.time_base
                written.mux(stream.encode(wide))
            written.mux(stream.encode(None))
    except (av.FFmpegError, IndexError):
        return False
    return True
