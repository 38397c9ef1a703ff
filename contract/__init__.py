"""What server, vehicle agent and simulator agreed on: geometry, roads, wire, run log."""
