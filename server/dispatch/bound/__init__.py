"""Proven lower bounds of static dial-a-ride instances: column generation, route enumeration, branch and bound."""
