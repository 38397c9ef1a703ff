"""From a file of OpenStreetMap to a network that the server runs: uploaded, checked, published, by a script."""

import time
from typing import Any

from tests.e2e.server_process import ROOT, ServerProcess

_SOURCE = ROOT / "maps" / "shanghai-university" / "shanghai-university-baoshan.osm.pbf"


def import_s(server: ServerProcess) -> float:
    """Until the server answers with the new map. No shuttle may be under way."""
    server.http.timeout = 300.0
    begun_s = time.perf_counter()
    made = server.http.post(
        "/maps/drafts/files", params={"file_name": _SOURCE.name}, content=_SOURCE.read_bytes()
    )
    draft: dict[str, Any] = made.raise_for_status().json()
    path = f"/maps/drafts/{draft['draft_id']}"
    found = server.http.get(f"{path}/problems").raise_for_status().json()
    if found["count"]:
        raise RuntimeError(f"the imported map has {found['count']} problems: {found['problems'][0]}")
    headers = {"If-Match": str(draft["revision"])}
    published = server.http.post(f"{path}/publications", headers=headers).raise_for_status().json()
    if server.http.get("/campus").json()["map_version"] != published["map_version"]:
        raise RuntimeError("the server does not serve the map that it has published")
    return time.perf_counter() - begun_s
