"""Whether sensors send what they should: rate, latency, clock, plausibility; live or recorded."""
