"""Command lines for the person who keeps an installation running."""
