"""CARMEN logs: planar laser scans with odometry, as text."""
