"""KISS-ICP in an environment of its own: scans come on stdin, poses and CPU times go to stdout.

Run by the interpreter of that environment (make odometry-peers), without anything of ours. Each scan: the
number of points (8 bytes), 1 if it has times, x, y and z of all points, and of each its share of the scan's
time, as float64.
"""

import struct
import sys
import time

import numpy as np
from kiss_icp.config.parser import load_config
from kiss_icp.kiss_icp import KissICP


def main() -> None:
    source, answers = sys.stdin.buffer, sys.stdout.buffer
    odometry = KissICP(load_config(None))
    while header := source.read(16):
        count, timed = struct.unpack("<qq", header)
        points = np.frombuffer(source.read(24 * count), dtype="<f8").reshape(count, 3).copy()
        times = np.frombuffer(source.read(8 * count), dtype="<f8") if timed else np.array([])
        began_s = time.process_time()
        odometry.register_frame(points, times)
        cpu_s = time.process_time() - began_s
        answers.write(struct.pack("<d", cpu_s) + np.asarray(odometry.last_pose, dtype="<f8").tobytes())
        answers.flush()


if __name__ == "__main__":
    main()
