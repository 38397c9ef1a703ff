"""Maps of points in tiles: what lidar mapping writes and scan-to-map localization reads."""
