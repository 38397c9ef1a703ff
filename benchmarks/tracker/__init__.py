"""How well tracks keep the identities of road users."""
