"""Parcels of lidar scans: what a vehicle keeps of an area, and what the server makes a map of."""
