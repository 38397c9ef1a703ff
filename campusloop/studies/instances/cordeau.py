"""Dial-a-ride instances as Cordeau and Laporte published them (2003; Cordeau 2006; Ropke, Cordeau,
Laporte 2007).

A header (vehicles, n, longest route, places, longest ride), then a row a node: number, x, y, service time,
load, window. Drop-offs follow the pickups in the same order. In some files n counts requests and in others
nodes, and some repeat the depot as a last row; the number of rows decides.
"""

import numpy as np

from campusloop.studies.instances.instance import Instance, InstanceBroken, checked
from campusloop.studies.instances.rows import numbered_rows, whole
from server.dispatch.arrays import AnyArray

_HEADER = 5
_COLUMNS = 7


def instance_from_cordeau(name: str, text: str) -> Instance:
    """Raises InstanceBroken, naming the line."""
    (first, header), *rows = numbered_rows(name, text)
    if len(header) != _HEADER:
        raise InstanceBroken(
            f"{name}, line {first}: the header has {len(header)} numbers instead of {_HEADER}"
        )
    vehicles = whole(name, first, "the number of vehicles", header[0])
    n = whole(name, first, "the number of nodes", header[1])
    for index, (line, row) in enumerate(rows):
        if len(row) != _COLUMNS:
            raise InstanceBroken(f"{name}, line {line}: {len(row)} columns instead of {_COLUMNS}")
        if row[0] != index:
            raise InstanceBroken(
                f"{name}, line {line}: node {row[0]:g} stands where {index} should; a row is missing"
            )
    table = np.array([row for _, row in rows])
    requests = _requests(name, n, table)
    table, end = table[: 2 * requests + 1], table[2 * requests + 1 :]
    late = table[:, 6].copy()
    if len(end):
        late[0] = min(late[0], end[0, 6])
    pickups = np.arange(1, requests + 1)
    return checked(
        Instance(
            name=name,
            vehicles=vehicles,
            capacity=whole(name, first, "the number of places", header[3]),
            duration_max=header[2],
            ride_max=header[4],
            nodes=table[:, 0].astype(np.int64),
            xy=table[:, 1:3].copy(),
            service=table[:, 3].copy(),
            load=np.array([whole(name, line, "the load", row[4]) for line, row in rows[: len(table)]]),
            early=table[:, 5].copy(),
            late=late,
            pairs=np.column_stack([pickups, pickups + requests]),
        )
    )


def _requests(name: str, n: int, table: AnyArray) -> int:
    """The number of requests: n requests or n nodes, with or without the depot repeated at the end."""
    rows = len(table)
    for requests in (n, n // 2):
        for ends in (0, 1):
            if (
                rows == 2 * requests + 1 + ends
                and _pickups_first(table, requests)
                and (ends == 0 or table[-1, 4] == 0)
            ):
                return requests
    raise InstanceBroken(
        f"{name}: {rows} rows do not fit n = {n}; expected the depot and {n} nodes or {2 * n} nodes, "
        "pickups first, with or without the depot repeated at the end"
    )


def _pickups_first(table: AnyArray, requests: int) -> bool:
    loads = table[1 : 2 * requests + 1, 4]
    return requests > 0 and bool((loads[:requests] > 0).all() and (loads[requests:] < 0).all())
