"""Sends commands to one vehicle."""

from dataclasses import replace

from contract.geometry import Pose2
from contract.wire.messages import CommandKind
from server.domain.fleet.vehicles import VehicleCommand
from server.usecases.ports import topics
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record.enrolled_vehicles import enrolled_vehicle
from server.usecases.record.server_events import record_event


def send_command(
    uow: UnitOfWork,
    vehicle_id: str,
    kind: CommandKind,
    by: str,
    text: str = "",
    announcement_id: str = "",
    pose: Pose2 | None = None,
) -> VehicleCommand:
    """Store a command, which is sent to the vehicle until it answers. Raises VehicleUnknown."""
    vehicle = enrolled_vehicle(uow, vehicle_id)
    if vehicle.hold_ends is not None and kind in ("resume", "stop_now"):
        uow.vehicles.save(replace(vehicle, hold_ends=None))
    command = VehicleCommand(
        campus_id=uow.campus_id,
        command_id=uow.ids.new_id("command"),
        vehicle_id=vehicle_id,
        kind=kind,
        text=text,
        by=by,
        made_at=uow.now,
        announcement_id=announcement_id,
        pose=pose,
    )
    uow.vehicles.add_command(command)
    record_event(uow, f"vehicle.{kind}", vehicle_id, by, text or _pose_text(pose))
    uow.publish(topics.vehicle_outbox(uow.campus_id, vehicle_id))
    return command


def _pose_text(pose: Pose2 | None) -> str:
    return "" if pose is None else f"{pose.x_m:.1f} {pose.y_m:.1f} {pose.yaw_rad:.2f}"
