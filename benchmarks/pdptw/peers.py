"""Other programs on pickup-and-delivery instances, for comparison. They are for development only.

Both count in whole numbers: distances are scaled and rounded up, so that their routes are on time. Each runs
in a process of its own, for OR-tools cannot be loaded beside the engine's HiGHS:

    python -m benchmarks.pdptw.peers NAME SECONDS SEED < pickled instance > routes as JSON
"""

import importlib
import importlib.util
import json
import math
import pickle
import subprocess
import sys
from collections.abc import Callable, Sequence

from campusloop.studies.instances.instance import Instance

Routes = Sequence[Sequence[int]]
_SCALE = 1000
# More than any route can cost, so that vehicles count first.
_VEHICLE = 10_000_000
# Share of PyVRP's time for fewer vehicles.
_FLEET = 0.4


def peer_routes(name: str, instance: Instance, seconds: float, seed: int) -> Routes:
    """Routes in node numbers that a peer finds in so many seconds of wall time; none where it fails."""
    command = [sys.executable, "-m", "benchmarks.pdptw.peers", name, str(seconds), str(seed)]
    done = subprocess.run(command, input=pickle.dumps(instance), stdout=subprocess.PIPE, check=False)
    if done.returncode:
        print(f"{name} failed on {instance.name}")
        return []
    routes: Routes = json.loads(done.stdout.splitlines()[-1])
    return routes


def main() -> None:
    name, seconds, seed = sys.argv[1:]
    instance: Instance = pickle.load(sys.stdin.buffer)
    print(json.dumps(PEERS[name](instance, float(seconds), int(seed))))


def ortools_routes(instance: Instance, seconds: float, seed: int) -> Routes:
    pywrapcp = importlib.import_module("ortools.constraint_solver.pywrapcp")
    enums = importlib.import_module("ortools.constraint_solver.routing_enums_pb2")
    legs, n = _legs(instance), len(instance.nodes)
    manager = pywrapcp.RoutingIndexManager(n, instance.vehicles, 0)
    routing = pywrapcp.RoutingModel(manager)
    service = [round(_SCALE * float(s)) for s in instance.service]
    drive = routing.RegisterTransitMatrix(legs)
    routing.SetArcCostEvaluatorOfAllVehicles(drive)
    routing.SetFixedCostOfAllVehicles(_VEHICLE)
    times = routing.RegisterTransitMatrix([[leg + service[a] for leg in legs[a]] for a in range(n)])
    end = round(_SCALE * float(instance.late[0]))
    routing.AddDimension(times, end, end, False, "time")
    loads = routing.RegisterUnaryTransitVector([int(q) for q in instance.load])
    routing.AddDimension(loads, 0, instance.capacity, True, "load")
    clock = routing.GetDimensionOrDie("time")
    for row in range(1, n):
        window = round(_SCALE * float(instance.early[row])), round(_SCALE * float(instance.late[row]))
        clock.CumulVar(manager.NodeToIndex(row)).SetRange(*window)
    solver = routing.solver()
    for p, d in instance.pairs:
        a, b = manager.NodeToIndex(int(p)), manager.NodeToIndex(int(d))
        routing.AddPickupAndDelivery(a, b)
        solver.Add(routing.VehicleVar(a) == routing.VehicleVar(b))
        solver.Add(clock.CumulVar(a) <= clock.CumulVar(b))
    how = pywrapcp.DefaultRoutingSearchParameters()
    how.first_solution_strategy = enums.FirstSolutionStrategy.PARALLEL_CHEAPEST_INSERTION
    how.local_search_metaheuristic = enums.LocalSearchMetaheuristic.GUIDED_LOCAL_SEARCH
    how.time_limit.FromMilliseconds(round(1000 * seconds))
    found = routing.SolveWithParameters(how)
    if found is None:
        return []
    routes = []
    for vehicle in range(instance.vehicles):
        route, index = [], found.Value(routing.NextVar(routing.Start(vehicle)))
        while not routing.IsEnd(index):
            route.append(int(instance.nodes[manager.IndexToNode(index)]))
            index = found.Value(routing.NextVar(index))
        routes.append(route)
    return routes


def pyvrp_routes(instance: Instance, seconds: float, seed: int) -> Routes:
    import pyvrp
    from pyvrp.stop import MaxRuntime

    legs, n = _legs(instance), len(instance.nodes)
    early = [round(_SCALE * float(t)) for t in instance.early]
    late = [round(_SCALE * float(t)) for t in instance.late]
    service = [round(_SCALE * float(t)) for t in instance.service]

    def model_with(vehicles: int) -> "pyvrp.Model":
        model = pyvrp.Model()
        places = [model.add_location(x=float(x), y=float(y)) for x, y in instance.xy]
        depot = model.add_depot(places[0], tw_early=early[0], tw_late=late[0])
        model.add_vehicle_type(vehicles, int(instance.capacity), depot, depot, fixed_cost=_VEHICLE)
        for p, d in instance.pairs:
            model.add_shipment(
                places[p], places[d], early[p], late[p], service[p], early[d], late[d], service[d],
                int(instance.load[p]),
            )  # fmt: skip
        for a in range(n):
            for b in range(n):
                model.add_edge(places[a], places[b], legs[a][b], legs[a][b])
        return model

    fewest = pyvrp.minimise_fleet(
        model_with(instance.vehicles).data(), MaxRuntime(_FLEET * seconds), seed
    ).num_available
    rest = MaxRuntime((1.0 - _FLEET) * seconds)
    result = model_with(fewest).solve(rest, seed=seed, collect_stats=False, display=False)
    if not result.is_feasible():
        return []
    return [
        [
            int(instance.nodes[instance.pairs[visit.idx][0 if visit.is_pickup() else 1]])
            for visit in route.schedule()
            if visit.is_shipment()
        ]
        for route in result.best.routes()
    ]


PEERS: dict[str, Callable[[Instance, float, int], Routes]] = {
    "ortools": ortools_routes,
    "pyvrp": pyvrp_routes,
}


def missing_peers() -> list[str]:
    return [name for name in PEERS if importlib.util.find_spec(name) is None]


def _legs(instance: Instance) -> list[list[int]]:
    rows = instance.xy
    return [[math.ceil(_SCALE * math.dist(a, b) - 1e-6) for b in rows] for a in rows]


if __name__ == "__main__":
    main()
