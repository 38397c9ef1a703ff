"""A camera over a crossing: video, where its pixels are on the map, who is in the area, and the reports."""
