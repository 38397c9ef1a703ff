"""Open planners and simple rules in the scenes that our stacks drive: `python -m benchmarks.peers`."""
