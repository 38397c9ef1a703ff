"""Recorded people who heed a vehicle."""
