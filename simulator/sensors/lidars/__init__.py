"""Spinning lidars and planar laser scanners in a cast scene: each firing from the sensor's own pose."""
