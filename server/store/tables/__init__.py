"""Every table. A campus is the shard: campus_id leads every key.

Change a table only together with a migration in migrations/versions.
"""

from server.store.tables.fleet import (
    event_logs,
    history,
    server_events,
    vehicle_commands,
    vehicle_events,
    vehicles,
    whereabouts,
)
from server.store.tables.metadata import (
    metadata,
)
from server.store.tables.planning import (
    driven_legs,
    held_sections,
    open_legs,
    orders,
    plans,
    section_routes,
    travel_time_factors,
)
from server.store.tables.records import (
    audit_entries,
    command_answers,
    counters,
    developer_tokens,
    enrolment_codes,
    incidents,
    leases,
    operator_sessions,
    operators,
    runs,
    second_factors,
    segments,
    ticket_keys,
    vehicle_keys,
    webhooks,
)
from server.store.tables.rides import (
    decisions,
    occurrences,
    ride_decisions,
    ride_feedback,
    rides,
    series,
    taps,
)
from server.store.tables.service import (
    closures,
    departures,
    maps,
    service_exceptions,
    service_patterns,
)

__all__ = [
    "audit_entries",
    "closures",
    "command_answers",
    "counters",
    "decisions",
    "departures",
    "developer_tokens",
    "driven_legs",
    "enrolment_codes",
    "event_logs",
    "held_sections",
    "history",
    "incidents",
    "leases",
    "maps",
    "metadata",
    "occurrences",
    "open_legs",
    "operator_sessions",
    "operators",
    "orders",
    "plans",
    "ride_decisions",
    "ride_feedback",
    "rides",
    "runs",
    "second_factors",
    "section_routes",
    "segments",
    "series",
    "server_events",
    "service_exceptions",
    "service_patterns",
    "taps",
    "ticket_keys",
    "travel_time_factors",
    "vehicle_commands",
    "vehicle_events",
    "vehicle_keys",
    "vehicles",
    "webhooks",
    "whereabouts",
]
