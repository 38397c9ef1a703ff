"""A vehicle of the fleet: its body and disk stay, while computers boot and crash."""

import random

from campusloop.simulation.clocks import BootClock
from campusloop.simulation.fleet.body import Body
from campusloop.simulation.fleet.computer import Computer
from campusloop.simulation.fleet.surroundings import Cabin, Observer, VehicleSetup
from campusloop.simulation.fleet.vehicle_disk import VehicleDisk
from campusloop.simulation.fleet.vehicle_link import VehicleLink
from campusloop.simulation.schedule import Dialler, Schedule
from contract.wire.messages import VehicleEvent
from vehicle_agent.mission.memory import MissionMemory

REBOOT_S = (15.0, 60.0)
DRIFT_MAX = 5e-5


class SimulatedVehicle:
    """`boot`, then it steps by itself; `crash` ends the computer, and the disk and the body stay."""

    def __init__(
        self,
        setup: VehicleSetup,
        body: Body,
        timeline: Schedule,
        network: Dialler,
        cabin: Cabin,
        observer: Observer,
    ) -> None:
        self.setup, self.body = setup, body
        self.boot_id = ""
        self.forged: list[VehicleEvent] = []
        self.rng: random.Random = timeline.rng(setup.vehicle_id)
        self.disk = VehicleDisk(setup.folder, self.rng)
        self.battery_ratio = self.rng.uniform(0.5, 1.0)
        self._timeline, self._network, self._cabin, self._observer = timeline, network, cabin, observer
        self._boots = 0
        self._is_frozen = False
        self._computer: Computer | None = None

    @property
    def is_running(self) -> bool:
        return self._computer is not None and not self._is_frozen

    @property
    def link(self) -> VehicleLink | None:
        return None if self._computer is None else self._computer.link

    @property
    def memory(self) -> MissionMemory | None:
        """What the computer knows of its orders; None while it is off."""
        return None if self._computer is None else self._computer.state.memory

    @property
    def oldest_event(self) -> tuple[str, int] | None:
        """Boot and number of the oldest event that the server has not acknowledged."""
        return None if self._computer is None else self._computer.oldest_event()

    @property
    def is_held(self) -> bool:
        return self._computer is not None and self._computer.state.held

    def boot(self) -> None:
        """A new boot with the memory on disk."""
        self._boots += 1
        self._is_frozen = False
        self.boot_id = f"{self.setup.vehicle_id}-boot-{self._boots}"
        clock = BootClock(self._timeline, self._timeline.now_ns, self.rng.uniform(-DRIFT_MAX, DRIFT_MAX))
        self.body.new_computer()
        self._computer = Computer(self, clock, self._timeline, self._network, self._cabin, self._observer)

    def crash(self) -> None:
        """Power is lost; it is back after a while."""
        if self._computer is None:
            return
        self._computer.end()
        self._computer = None
        self.body.speed_mps = 0.0
        self._timeline.after(self.rng.uniform(*REBOOT_S), self._boot_again)

    def freeze(self, duration_s: float) -> None:
        """The computer stands still and the gate brakes; then it goes on where it was."""
        computer = self._computer
        if computer is None or self._is_frozen:
            return
        self._is_frozen = True
        computer.freeze()
        self._timeline.after(duration_s, lambda: self._thaw(computer))

    def _thaw(self, computer: "Computer") -> None:
        if computer is self._computer and self._is_frozen:
            self._is_frozen = False
            computer.thaw()

    def _boot_again(self) -> None:
        if self._computer is None:
            self.boot()
