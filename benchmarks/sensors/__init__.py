"""What simulated lidars cost."""
