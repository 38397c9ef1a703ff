"""How well each stack knows where it is: `python -m benchmarks.localization`."""
