"""Words to one vehicle: hold, resume, announce."""

from server.domain.vehicles import CommandKind, VehicleCommand
from server.usecases.ports import UnitOfWork


def send_command(
    uow: UnitOfWork, vehicle_id: str, kind: CommandKind, by: str, text: str = ""
) -> VehicleCommand:
    """Repeat it to the vehicle until it says that it is done. Raises VehicleUnknown."""
    raise NotImplementedError
