"""Proven lower bounds of static dial-a-ride: column generation, enumeration, branch and bound."""
