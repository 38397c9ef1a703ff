"""Open planners and simple rules in the scenes of our stacks: `python -m benchmarks.peers`."""
