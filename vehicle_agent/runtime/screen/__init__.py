"""The onboard screen: what it shows, what it may ask for, and its pages."""
