"""What happened to a service under faults, and what must hold all the same. Pure."""
