"""Offline work on recorded sensor logs: what is built once and used by vehicles afterwards."""
