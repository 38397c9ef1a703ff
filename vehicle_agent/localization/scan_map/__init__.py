"""Where a lidar scan lies on a map of surfaces; runs in a worker, pure."""
