"""Cameras in the scene: pinhole pictures by ray casting, with people that a people detector recognises."""
