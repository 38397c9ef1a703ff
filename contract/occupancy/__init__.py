"""Occupancy maps: which parts of a place are occupied, as a laser at one height sees them."""
