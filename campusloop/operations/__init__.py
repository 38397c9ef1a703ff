"""What a person does to an installation: databases to copy, and checks of everything that a server needs."""
