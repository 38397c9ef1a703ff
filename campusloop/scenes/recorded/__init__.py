"""Scenes from recordings."""
