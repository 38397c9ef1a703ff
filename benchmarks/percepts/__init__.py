"""What the percepts of a vehicle miss, and how late they are."""
