"""What the demos' operator reads is what the API answers."""

from campusloop.clients.operator_client import ReportedRide, ReportedVehicle
from server.api.rides.schemas import RideRecord
from server.api.vehicles.schemas import VehicleDetail


def test_the_client_reads_no_field_that_the_api_does_not_have() -> None:
    assert set(ReportedRide.__annotations__) <= set(RideRecord.model_fields)
    assert set(ReportedVehicle.__annotations__) <= set(VehicleDetail.model_fields)
