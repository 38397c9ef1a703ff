"""Traffic signs by their retro-reflective boards: five stages on each scan (GEM, section VI), then tracks."""
