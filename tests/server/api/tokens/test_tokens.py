from tests.server.api.server_under_test import ServerUnderTest


def test_a_token_shows_its_secret_once(server: ServerUnderTest) -> None:
    headers = server.sign_in()
    made = server.post("/developer-tokens", {"name": "night", "scopes": ["drive", "read"]}, headers=headers)
    assert made.status_code == 201
    assert len(made.json()["secret"]) >= 22
    listed = server.get("/developer-tokens")
    assert [(token["name"], token["scopes"]) for token in listed.json()] == [("night", ["drive", "read"])]
    assert made.json()["secret"] not in listed.text


def test_a_revoked_token_stays_listed_and_an_unknown_one_is_a_404(server: ServerUnderTest) -> None:
    headers = server.sign_in()
    made = server.post("/developer-tokens", {"name": "night", "scopes": ["read"]}, headers=headers).json()
    revoked = server.request("DELETE", f"/developer-tokens/{made['token_id']}", headers=headers)
    assert revoked.status_code == 200
    assert revoked.json()["revoked_at"] is not None
    unknown = server.request("DELETE", "/developer-tokens/token-99", headers=headers)
    assert (unknown.status_code, unknown.json()["code"]) == (404, "token_unknown")


def test_scopes_are_of_the_house_and_validity_is_bounded(server: ServerUnderTest) -> None:
    headers = server.sign_in()
    for wrong in ({"scopes": ["fly"]}, {"scopes": []}, {"valid_days": 10_000}, {"name": "\x00"}):
        body = {"name": "night", "scopes": ["read"]} | wrong
        assert server.post("/developer-tokens", body, headers=headers).status_code == 422
