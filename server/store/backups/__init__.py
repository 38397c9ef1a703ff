"""Verified backups of a database file, and restoring them."""
