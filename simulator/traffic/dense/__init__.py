"""People of dense places: those who come out of doors, and those who follow the shuttle."""
