"""The learnt travel times over REST."""

from tests.server.api.server_under_test import ServerUnderTest


def test_operators_see_the_factor_of_every_hour(server: ServerUnderTest) -> None:
    assert server.get("/travel-times").status_code == 401
    server.sign_in()
    found = server.get("/travel-times").json()
    assert (found["timezone"], found["learned_at"]) == ("Asia/Shanghai", None)
    assert found["hours"] == [{"hour": hour, "factor": 1.0, "legs": 0} for hour in range(24)]
