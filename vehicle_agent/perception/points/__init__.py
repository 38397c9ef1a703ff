"""Ground, obstacle cells and objects from points, without a network."""
