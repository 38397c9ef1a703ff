"""The targets of a live campus's large processes. Each imports its code in its own process.

Importing the server takes three seconds, and the process that starts it does not need it.
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


def take_pictures(*arguments: Any) -> None:
    """`camera_pictures.take_pictures_of_vehicles` in a process of its own."""
    from campusloop.live.camera_pictures import take_pictures_of_vehicles

    take_pictures_of_vehicles(*arguments)
