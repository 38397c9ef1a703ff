"""Video of a vehicle's cameras: what is read, checked, encoded and kept."""
