"""What the whole fleet did in the past: positions, and what happened."""
