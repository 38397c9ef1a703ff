"""The link's part of live pictures: requests of operators, to the process that has the cameras."""

from collections.abc import Callable

from contract.wire.messages import CameraPicture, Command
from vehicle_agent.runtime.processes.clock import Clock
from vehicle_agent.runtime.video.camera_view import ShowCamera

SHOWN_NS = 60_000_000_000


class CameraRequests:
    """The tick answers the command itself, as every command; pictures do not pass through it."""

    def __init__(
        self,
        clock: Clock,
        post: Callable[[ShowCamera], bool] | None,
        show: Callable[[CameraPicture], None],
    ) -> None:
        """post: to the process that records video, False if it is away; None on a vehicle without cameras."""
        self._clock, self._post, self._show = clock, post, show

    def hear(self, command: Command) -> None:
        """Any command of the server, which sends no request that lay with it for more than some seconds."""
        if command.kind != "show_camera":
            return
        now_ns = self._clock.now_ns()
        if self._post is None:
            self._show(CameraPicture(0, now_ns, command.text, "no_cameras"))
        elif not self._post(ShowCamera(command.text, now_ns + SHOWN_NS)):
            detail = "the process that records video is away"
            self._show(CameraPicture(0, now_ns, command.text, "failed", detail=detail))
