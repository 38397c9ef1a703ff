"""Pickup-and-delivery instances as Li and Lim published them (2001).

A header (vehicles, places, speed), then a row for each node: number, x, y, demand, window, service time, the
number of its pickup (0 for a pickup) and of its drop-off (0 for a drop-off). The number of vehicles is
minimised before the distance.
"""

import math

import numpy as np

from campusloop.studies.instances.instance import Instance, InstanceBroken, checked
from campusloop.studies.instances.rows import numbered_rows, whole

_HEADER = 3
_COLUMNS = 9


def instance_from_li_lim(name: str, text: str) -> Instance:
    """Raises InstanceBroken, naming the line."""
    (first, header), *rows = numbered_rows(name, text)
    if len(header) != _HEADER:
        raise InstanceBroken(
            f"{name}, line {first}: the header has {len(header)} numbers instead of {_HEADER}"
        )
    for index, (line, row) in enumerate(rows):
        if len(row) != _COLUMNS:
            raise InstanceBroken(f"{name}, line {line}: {len(row)} columns instead of {_COLUMNS}")
        if row[0] != index:
            raise InstanceBroken(
                f"{name}, line {line}: node {row[0]:g} stands where {index} should; a row is missing"
            )
    table = np.array([row for _, row in rows])
    pairs = []
    for line, row in rows[1:]:
        pickup = whole(name, line, "the pickup", row[7])
        dropoff = whole(name, line, "the drop-off", row[8])
        node = int(row[0])
        if (pickup == 0) == (dropoff == 0):
            raise InstanceBroken(f"{name}, line {line}: node {node} must name its pickup or its drop-off")
        partner = pickup or dropoff
        if not 0 < partner < len(table):
            raise InstanceBroken(
                f"{name}, line {line}: node {node} belongs to node {partner}, which has no row"
            )
        if table[partner, 8 if pickup else 7] != node:
            raise InstanceBroken(f"{name}, line {line}: nodes {node} and {partner} do not name each other")
        if dropoff:
            pairs.append((node, dropoff))
    if not pairs:
        raise InstanceBroken(f"{name}: the file has no requests")
    return checked(
        Instance(
            name=name,
            vehicles=whole(name, first, "the number of vehicles", header[0]),
            capacity=whole(name, first, "the number of places", header[1]),
            duration_max=math.inf,
            ride_max=math.inf,
            nodes=table[:, 0].astype(np.int64),
            xy=table[:, 1:3].copy(),
            service=table[:, 6].copy(),
            load=np.array([whole(name, line, "the demand", row[3]) for line, row in rows]),
            early=table[:, 4].copy(),
            late=table[:, 5].copy(),
            pairs=np.array(pairs),
            fewest_vehicles_first=True,
        )
    )
