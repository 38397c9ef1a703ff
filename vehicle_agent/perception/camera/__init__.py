"""Pictures: where things are in them, whether a camera can be believed, and who is a person."""
