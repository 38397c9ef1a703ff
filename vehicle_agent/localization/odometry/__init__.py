"""The vehicle's motion from lidar scans alone; runs in a worker, pure."""
