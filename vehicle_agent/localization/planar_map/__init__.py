"""Planar scans in an occupancy map of a whole campus: the worker's part, and the likelihood around it."""
