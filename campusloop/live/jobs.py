"""The big processes of a live campus by name: each imports what it runs itself, and who starts it does not.

Importing the server takes three seconds; the process that starts it needs nothing of it.
"""

from typing import Any


def serve(*arguments: Any, **options: Any) -> None:
    """`server.serve_campus` in a process of its own."""
    from campusloop.live.server import serve_campus

    serve_campus(*arguments, **options)


def simulate(*arguments: Any) -> None:
    """`simulation.simulate_vehicles` in a process of its own."""
    from campusloop.live.simulation import simulate_vehicles

    simulate_vehicles(*arguments)
