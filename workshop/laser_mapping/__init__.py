"""Occupancy maps from laser logs: simultaneous localization and mapping in the plane."""
