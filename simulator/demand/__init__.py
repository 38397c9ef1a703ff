"""How many rides a campus asks for, when, and from where to where."""
