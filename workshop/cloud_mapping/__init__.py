"""From recorded lidar scans to a map of points in tiles: odometry, loops, GNSS, a pose graph, surfaces."""
