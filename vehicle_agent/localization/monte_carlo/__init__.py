"""Monte-Carlo localization: the laser's pose in an occupancy map, by particles."""
