"""The contract of server, vehicle agent and simulator: geometry, roads, wire, run log."""
