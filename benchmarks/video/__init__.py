"""What recording four cameras costs the vehicle that drives meanwhile, and what a kill loses."""
