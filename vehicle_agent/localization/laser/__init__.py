"""Localization with a planar laser: scan matching, dead reckoning, Monte-Carlo localization in a map."""
