"""Where the lidars of a vehicle sit to each other, from one scene that all of them see."""
