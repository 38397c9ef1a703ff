"""Scenes: one vehicle, one way to drive, and whoever moves around it; driven by the whole onboard loop."""
