"""Ride demand of a campus: numbers, times and stops."""
