"""Bytes by their hash, in a folder or in an object store: run segments, and tiles of localization maps."""
