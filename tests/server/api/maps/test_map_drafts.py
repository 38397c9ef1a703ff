"""Drawing maps over REST: versions, drafts by revision, checks, publication and roll-back."""

import json
from typing import Any

import pytest

from contract.roads.load import decode_map, encode_map
from server.api.maps.uploads import FILE_BYTES_MAX
from server.feeds.roads.exchange.formats import EXPORTS
from server.feeds.roads.generated import generated_osm
from tests.server.api.rides.test_rides import book, campus
from tests.server.api.server_under_test import ServerUnderTest
from tests.server.usecases.shipped_maps import shipped_map

__all__ = ["campus"]

GEOJSON = EXPORTS["geojson"](shipped_map("snow-lion"))


@pytest.fixture
def operator(server: ServerUnderTest) -> dict[str, str]:
    return server.sign_in()


def draft(server: ServerUnderTest, headers: dict[str, str], name: str = "Mine") -> dict[str, Any]:
    answer = server.post("/maps/drafts", {"name": name}, headers=headers)
    assert answer.status_code == 201, answer.text
    made: dict[str, Any] = answer.json()
    return made


def change(server: ServerUnderTest, headers: dict[str, str], of: dict[str, Any], **body: object) -> Any:
    headers = headers | {"If-Match": str(of["revision"]), "Content-Type": "application/json"}
    return server.request("PATCH", f"/maps/drafts/{of['draft_id']}", json=body, headers=headers)


def upload(
    server: ServerUnderTest, headers: dict[str, str], content: bytes, name: str, query: str = ""
) -> Any:
    path = f"/maps/drafts/files?file_name={name}{query}"
    return server.request("POST", path, content=content, headers=headers)


def found(server: ServerUnderTest, of: dict[str, Any]) -> list[str]:
    answer = server.get(f"/maps/drafts/{of['draft_id']}/problems")
    assert answer.status_code == 200, answer.text
    return [problem["defect"] for problem in answer.json()["problems"]]


def publish(server: ServerUnderTest, headers: dict[str, str], of: dict[str, Any]) -> Any:
    path = f"/maps/drafts/{of['draft_id']}/publications"
    return server.request("POST", path, headers=headers | {"If-Match": str(of["revision"])})


def test_a_copy_is_drawn_on_published_and_rolled_back(
    server: ServerUnderTest, operator: dict[str, str]
) -> None:
    before = server.get("/campus").json()["map_version"]
    made = draft(server, operator)
    assert (made["revision"], made["based_on"]) == (1, before)
    whole = server.get(f"/maps/drafts/{made['draft_id']}").json()
    stop = whole["elements"]["stops"][0] | {"name": "New name"}
    changed = change(server, operator, made, put={"stops": [stop]})
    assert (changed.status_code, changed.json()["revision"]) == (200, 2)
    assert found(server, made) == []
    diff = server.get(f"/maps/drafts/{made['draft_id']}/diff").json()
    assert diff["kinds"]["stops"] == {"added": [], "removed": [], "changed": [stop["stop_id"]]}
    published = publish(server, operator, changed.json())
    assert published.status_code == 201, published.text
    assert server.get("/stops").json()[0]["name"] == "New name"
    assert server.get("/maps/drafts").json() == []
    versions = {one["map_version"]: one["active"] for one in server.get("/maps").json()}
    assert versions == {before: False, published.json()["map_version"]: True}
    back = server.request("POST", f"/maps/{before}/activations", headers=operator)
    assert (back.status_code, back.json()["active"]) == (200, True)
    assert server.get("/campus").json()["map_version"] == before


def test_of_two_editors_the_second_loses_nothing(server: ServerUnderTest, operator: dict[str, str]) -> None:
    made = draft(server, operator)
    assert change(server, operator, made, removed={"kerbs": ["none"]}).status_code == 200
    late = change(server, operator, made, removed={"stops": ["C6"]})
    assert (late.status_code, late.json()["code"]) == (412, "draft_changed")
    stops = server.get(f"/maps/drafts/{made['draft_id']}").json()["elements"]["stops"]
    assert "C6" in {stop["stop_id"] for stop in stops}
    assert publish(server, operator, made).status_code == 412


def test_problems_have_a_place_and_are_mended_by_one_call(
    server: ServerUnderTest, operator: dict[str, str]
) -> None:
    made = draft(server, operator)
    stop = server.get(f"/maps/drafts/{made['draft_id']}").json()["elements"]["stops"][0]
    zone = {"zone_id": "z", "lane_id": stop["lane_id"], "s_from_m": stop["s_m"], "s_to_m": stop["s_m"] + 2.0}
    changed = change(server, operator, made, put={"no_stopping_zones": [zone]}).json()
    answer = server.get(f"/maps/drafts/{made['draft_id']}/problems").json()
    (problem,) = answer["problems"]
    assert (problem["defect"], problem["where"]) == ("in_no_stopping_zone", stop["stop_id"])
    assert problem["can_be_mended"]
    assert len(problem["place"]) == 2
    refused = publish(server, operator, changed)
    assert (refused.status_code, refused.json()["code"]) == (409, "draft_unsound")
    headers = operator | {"If-Match": "2"}
    path = f"/maps/drafts/{made['draft_id']}/fixes"
    mended = server.post(path, {"defect": problem["defect"], "where": problem["where"]}, headers=headers)
    assert mended.status_code == 200, mended.text
    assert found(server, made) == []
    nothing = server.post(
        path, {"defect": "kerb_in_the_way", "where": "k"}, headers=operator | {"If-Match": "3"}
    )
    assert (nothing.status_code, nothing.json()["code"]) == (409, "no_such_fix")


def test_a_sharp_bend_is_shown_where_it_is_and_smoothed(
    server: ServerUnderTest, operator: dict[str, str]
) -> None:
    made = draft(server, operator)
    lanes = server.get(f"/maps/drafts/{made['draft_id']}").json()["elements"]["lanes"]
    lane = next(one for one in lanes if len(one["points"]) > 60)
    x_m, y_m = lane["points"][20]
    lane["points"][20] = [x_m + 0.8, y_m + 0.8]
    change(server, operator, made, put={"lanes": [lane]})
    answer = server.get(f"/maps/drafts/{made['draft_id']}/problems").json()
    bend = next(one for one in answer["problems"] if one["defect"] == "too_sharp")
    assert bend["place"] == pytest.approx(lane["points"][20], abs=2.0)
    headers = operator | {"If-Match": "2"}
    wish = {"defect": "too_sharp", "where": lane["lane_id"]}
    assert server.post(f"/maps/drafts/{made['draft_id']}/fixes", wish, headers=headers).status_code == 200
    assert found(server, made) == []


def test_a_trial_drive_takes_its_time(server: ServerUnderTest, operator: dict[str, str]) -> None:
    made = draft(server, operator)
    path = f"/maps/drafts/{made['draft_id']}/trial-drives"
    drive = server.get(f"{path}?from_stop=NN20&to_stop=C6").json()
    assert drive["length_m"] / drive["time_s"] == pytest.approx(2.75, abs=1.0)
    assert len(drive["xy"]) > 20
    assert server.get(f"{path}?from_stop=NN20&to_stop=nowhere").json()["code"] == "stop_unknown"
    whole = server.get(f"/maps/drafts/{made['draft_id']}").json()["elements"]
    cut = [lane | {"successors": []} for lane in whole["lanes"]]
    change(server, operator, made, put={"lanes": cut})
    assert server.get(f"{path}?from_stop=NN20&to_stop=C6").json()["code"] == "stop_unreachable"


@pytest.mark.parametrize("kind", ["geojson", "lanelet2", "map"])
def test_an_export_is_taken_as_a_file_again(
    server: ServerUnderTest, operator: dict[str, str], kind: str
) -> None:
    version = server.get("/campus").json()["map_version"]
    exported = server.get(f"/maps/{version}/exports/{kind}")
    assert exported.status_code == 200
    assert version in exported.headers["content-disposition"]
    made = upload(server, operator, exported.content, "a-file")
    assert made.status_code == 201, made.text
    own = server.get(f"/maps/drafts/{made.json()['draft_id']}/exports/map")
    assert decode_map(own.content).map_version == version


def test_a_map_of_another_country_is_asked_about(server: ServerUnderTest, operator: dict[str, str]) -> None:
    refused = upload(server, operator, generated_osm(1), "far.osm")
    assert (refused.status_code, refused.json()["code"]) == (409, "map_elsewhere")
    assert "km from" in refused.json()["detail"]
    taken = upload(server, operator, generated_osm(1), "far.osm", "&elsewhere=true")
    assert taken.status_code == 201, taken.text
    assert taken.json()["repairs"]
    assert found(server, taken.json()) == []


@pytest.mark.parametrize(
    ("content", "code"),
    [(b"", "map_empty"), (GEOJSON[:5000], "geojson_broken"), (b"PK\x03\x04" + bytes(900), "osm_format")],
)
def test_a_bad_file_is_refused_with_what_to_do(
    server: ServerUnderTest, operator: dict[str, str], content: bytes, code: str
) -> None:
    refused = upload(server, operator, content, "a-file")
    assert (refused.status_code, refused.json()["code"]) == (400, "map_invalid")
    assert code in refused.json()["detail"]
    assert server.get("/maps/drafts").json() == []


def test_a_file_that_is_too_large_is_refused_before_it_is_read(
    server: ServerUnderTest, operator: dict[str, str]
) -> None:
    headers = operator | {"Content-Length": str(500 << 20)}
    refused = upload(server, headers, b"{", "large.osm")
    assert refused.status_code == 413
    assert FILE_BYTES_MAX < 500 << 20


def test_a_map_is_not_changed_under_a_shuttle_that_drives(
    campus: ServerUnderTest,
) -> None:
    operator = campus.sign_in()
    made = draft(campus, operator)
    lanes = campus.get(f"/maps/drafts/{made['draft_id']}").json()["elements"]["lanes"]
    slower = [lane | {"speed_limit_mps": 1.0} for lane in lanes]
    changed = change(campus, operator, made, put={"lanes": slower}).json()
    book(campus)
    refused = publish(campus, operator, changed)
    assert (refused.status_code, refused.json()["code"]) == (409, "map_in_use")
    assert "shuttle-1" in refused.json()["detail"]
    assert len(campus.get("/maps/drafts").json()) == 1


def test_only_who_may_draw_draws(server: ServerUnderTest) -> None:
    assert server.post("/maps/drafts", {"name": "x"}).status_code == 401
    operator = server.sign_in()
    assert server.post("/maps/drafts", {"name": "x"}).status_code == 403
    made = draft(server, operator)
    assert server.request("DELETE", f"/maps/drafts/{made['draft_id']}", headers=operator).status_code == 204
    gone = server.get(f"/maps/drafts/{made['draft_id']}")
    assert (gone.status_code, gone.json()["code"]) == (404, "draft_unknown")
    actions = [entry["action"] for entry in server.get("/audit").json()]
    assert "make_map_draft" in json.dumps(actions)


def test_the_restart_of_a_server_keeps_what_was_published(server: ServerUnderTest) -> None:
    from server.usecases.fleet import campus as campuses

    operator = server.sign_in()
    made = draft(server, operator)
    stop = server.get(f"/maps/drafts/{made['draft_id']}").json()["elements"]["stops"][0]
    changed = change(server, operator, made, put={"stops": [stop | {"name": "Other"}]}).json()
    version = publish(server, operator, changed).json()["map_version"]
    server.transact(lambda uow: campuses.load_map_at_start(uow, encode_map(shipped_map("snow-lion"))))
    assert server.get("/campus").json()["map_version"] == version
