from pathlib import Path
from contract.roads.load import load_map
from tests.server.usecases.campus_under_test import CampusUnderTest
from tests.server.usecases.fake_fleet import FakeFleet
import time

def test_one():
    m = load_map(Path(__file__).parents[3] / "maps/shanghai-university/map.json")
    t=time.perf_counter()
    c = CampusUnderTest(m)
    print("setup", time.perf_counter()-t)
    f = FakeFleet(c, m, 3).start()
    stops=[s.stop_id for s in m.stops]
    t=time.perf_counter()
    r = f.book(stops[0], stops[5], 2)
    print("book", time.perf_counter()-t, r.state, r.promise, r.vehicle_id, r.pickup_eta)
    for k in range(60): f.step()
    r2 = f.book(stops[3], stops[9], 2)
    print(r2)
    t=time.perf_counter()
    n0=c.clock.now()
    f.run_until_idle(4000)
    print("done", time.perf_counter()-t, (c.clock.now()-n0).total_seconds())
    print(f.ride(r.ride_id))
    print(c.read(lambda u:u.views.incidents()))
