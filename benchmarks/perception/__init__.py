"""What perception from points costs, and what it finds."""
