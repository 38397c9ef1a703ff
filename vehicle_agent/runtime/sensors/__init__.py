"""The sensors of a real vehicle: which there are (`sensors.toml`), and what is read from them."""
