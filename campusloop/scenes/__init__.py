"""Scenes: one vehicle, one path and the road users around it, driven by the whole onboard loop."""
