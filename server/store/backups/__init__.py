"""Verified backups of a database, and restoring a database file."""
