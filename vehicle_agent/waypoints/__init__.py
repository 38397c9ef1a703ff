"""Waypoint files: recorded by driving, one file for each speed (GEM, section IV)."""
