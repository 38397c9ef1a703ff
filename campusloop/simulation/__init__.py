"""The service in virtual time, with faults of every kind from a seed, and what must hold whatever fails."""
