"""Road maps in the formats of others: GeoJSON and Lanelet2, out and in."""
