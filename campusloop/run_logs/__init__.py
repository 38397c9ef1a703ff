"""Recorded runs on disk: which there are, what happened in one, and files of one for other programs."""
