"""A point map of the scans that vehicles kept of an area, beside the map in force: a proposal."""
