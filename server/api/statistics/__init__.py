"""Demand, service and driving of a stretch of time, in figures."""
