"""A client of openapi-python-client: it lists stops, books a ride as a developer, and reads the ride."""

import json
import sys

from campus_client import AuthenticatedClient
from campus_client.api.campus import list_stops
from campus_client.api.rides import book_ride, get_ride_record
from campus_client.models import RideRecord, RideRequest, RideTicket

server, token = sys.argv[1:]
with AuthenticatedClient(server, token) as client:
    stops = list_stops.sync(client=client)
    assert isinstance(stops, list), stops
    first, second = stops[:2]
    ticket = book_ride.sync(client=client, body=RideRequest(first.stop_id, second.stop_id))
    assert isinstance(ticket, RideTicket), ticket
    ride = get_ride_record.sync(ticket.ride_id, client=client)
    assert isinstance(ride, RideRecord), ride
    print(json.dumps({"ride_id": ride.ride_id, "source": str(ride.source), "state": str(ride.state)}))
