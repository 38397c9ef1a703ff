"""What perception from points finds in annotated sweeps."""
