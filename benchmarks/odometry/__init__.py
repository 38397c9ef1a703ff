"""How far lidar odometry drifts, beside KISS-ICP (python -m benchmarks.odometry)."""
