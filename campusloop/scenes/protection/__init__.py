"""Protection cells after the consumer tests, and the braking that each is compared with."""
