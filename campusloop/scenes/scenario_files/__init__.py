"""Scenario files: their format, the road users in them, and how a run is compared with what is expected."""
