"""How true a map of a campus is that is made from a lidar's drive (python -m benchmarks.mapping)."""
