"""How exactly several lidars are calibrated from a wall corner (python -m benchmarks.calibration)."""
