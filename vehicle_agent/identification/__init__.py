"""Offline: a vehicle's response from a recorded drive, and the profile that states it."""
