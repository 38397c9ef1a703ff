"""Every command of operators and developers to one vehicle: the console, REST and /ws/developer call these.

A hold, a recall and a reassignment also change the plans of the fleet; `interventions` has their effects.
"""

from dataclasses import dataclass

from contract.geometry import Pose2
from server.domain.errors import NoRestingPlaceFree, PlanChanged, VehicleMoves, VehicleNotConnected
from server.domain.fleet.vehicles import Vehicle, VehicleCommand
from server.domain.planning.plans import PlannedVisit
from server.domain.rides.effects import Effects, Intervention
from server.usecases.fleet.interventions import intervene
from server.usecases.planning import plans
from server.usecases.ports.unit_of_work import Transactions, UnitOfWork
from server.usecases.ports.views import VehicleView
from server.usecases.record.commands import send_command
from server.usecases.record.enrolled_vehicles import enrolled_vehicle

# A slower vehicle stands; the vehicle itself judges by its own speed.
STANDING_MPS = 0.05


@dataclass(frozen=True, slots=True)
class SentVehicle:
    """visit: the visit that the vehicle will make; vehicle: its plan and order with it."""

    visit: PlannedVisit
    plan_version: int
    vehicle: VehicleView


async def pause(
    transactions: Transactions, vehicle_id: str, by: str, for_s: float | None = None
) -> VehicleCommand:
    """Bring a vehicle to a comfortable stand, for `for_s` seconds or until it is resumed.

    Other vehicles take over the rides that the hold makes late. If the fleet cannot be replanned, the
    vehicle is held all the same, in a transaction of its own: safety does not wait for a plan. Raises
    VehicleUnknown.
    """

    def hold(uow: UnitOfWork) -> VehicleCommand:
        command = intervene(uow, vehicle_id, Intervention("hold", for_s), by).command
        assert command is not None
        return command

    try:
        return await transactions.run(hold)
    except (NoRestingPlaceFree, PlanChanged):
        return await transactions.run(lambda uow: send_command(uow, vehicle_id, "hold", by))


def resume(uow: UnitOfWork, vehicle_id: str, by: str) -> VehicleCommand:
    """Release a held vehicle. The vehicle may refuse, and says why. Raises VehicleUnknown."""
    return send_command(uow, vehicle_id, "resume", by)


def stop_now(uow: UnitOfWork, vehicle_id: str, by: str) -> VehicleCommand:
    """Stop a vehicle as hard as is safe; it stays held. Raises VehicleUnknown."""
    return send_command(uow, vehicle_id, "stop_now", by)


def announce(uow: UnitOfWork, vehicle_id: str, by: str, text: str) -> VehicleCommand:
    """Say a text aloud in a vehicle and show it on its screen. Raises VehicleUnknown."""
    return send_command(uow, vehicle_id, "announce", by, text)


def show_scene(uow: UnitOfWork, vehicle_id: str, by: str) -> VehicleCommand:
    """Let a vehicle send what it sees, for a minute. Raises VehicleUnknown, VehicleNotConnected."""
    if not enrolled_vehicle(uow, vehicle_id).connected:
        raise VehicleNotConnected(f"{vehicle_id} is out of reach; nothing that it sees can come now")
    return send_command(uow, vehicle_id, "show_scene", by)


def show_camera(uow: UnitOfWork, vehicle_id: str, camera: str, by: str) -> VehicleCommand:
    """Let a vehicle send pictures of a camera, for a minute. Raises VehicleUnknown, VehicleNotConnected."""
    if not enrolled_vehicle(uow, vehicle_id).connected:
        raise VehicleNotConnected(f"{vehicle_id} is out of reach; no picture can come now")
    return send_command(uow, vehicle_id, "show_camera", by, camera)


def set_position(uow: UnitOfWork, vehicle_id: str, pose: Pose2, by: str) -> VehicleCommand:
    """Tell a standing vehicle where it is; it compares its scans with the map there, and answers.

    pose: map frame. Raises VehicleUnknown, VehicleNotConnected, VehicleMoves.
    """
    if not enrolled_vehicle(uow, vehicle_id).connected:
        raise VehicleNotConnected(f"{vehicle_id} is out of reach: it cannot try a place now")
    whereabouts = uow.vehicles.whereabouts(vehicle_id)
    status = None if whereabouts is None else whereabouts.status
    if status is not None and abs(status.speed_mps) >= STANDING_MPS:
        raise VehicleMoves(f"{vehicle_id} drives at {status.speed_mps:.1f} m/s: hold it first")
    return send_command(uow, vehicle_id, "set_position", by, pose=pose)


def send(uow: UnitOfWork, vehicle_id: str, stop_id: str, by: str) -> SentVehicle:
    """Let a vehicle visit a stop without a ride, at the first chance that keeps every promise.

    Raises VehicleUnknown, StopUnknown, StopUnreachable, VehicleNotPlaced, VehicleOutOfService,
    NoRestingPlaceFree.
    """
    plan = plans.send_to_stop(uow, vehicle_id, stop_id, by)
    visit = next(visit for visit in reversed(plan.visits) if visit.stop_id == stop_id)
    vehicle = uow.views.vehicle(vehicle_id)
    assert vehicle is not None
    return SentVehicle(visit, plan.version, vehicle)


def recall(uow: UnitOfWork, vehicle_id: str, by: str) -> Vehicle:
    """Take a vehicle out of service. It first brings its riders home, then rests. Raises VehicleUnknown."""
    intervene(uow, vehicle_id, Intervention("recall"), by)
    return enrolled_vehicle(uow, vehicle_id)


def reassign(uow: UnitOfWork, vehicle_id: str, ride_id: str, to_vehicle_id: str, by: str) -> Effects:
    """Give one waiting ride of a vehicle, or all with "", to another vehicle, or to any with "".

    Raises what `interventions.reassign` raises.
    """
    intervention = Intervention("reassign", ride_id=ride_id, to_vehicle_id=to_vehicle_id)
    return intervene(uow, vehicle_id, intervention, by).effects
