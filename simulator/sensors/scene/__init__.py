"""The surroundings as triangles: one static scene for all vehicles of a world, one moving scene a tick."""
