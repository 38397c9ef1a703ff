"""People by a laser of one layer and cameras (NUS paper, section III-A): clusters, tracks, labels."""
