"""Budgets behind proxies and in IPv6 networks, over the whole server."""

from pathlib import Path

import pytest

from tests.server.api.server_under_test import PASSWORD, ServerUnderTest

WRONG = {"name": "operator", "password": "guess"}
PROXY, CLIENT, OTHER = "10.0.0.1", "192.0.2.7", "192.0.2.8"


def tries(server: ServerUnderTest, count: int, headers: dict[str, str] | None = None) -> list[int]:
    return [server.post("/session", WRONG, headers=headers or {}).status_code for _ in range(count)]


def behind(tmp_path: Path, **settings: object) -> ServerUnderTest:
    server = ServerUnderTest(tmp_path, trusted_proxies="10.0.0.0/8", login_tries_per_minute=1, **settings)
    server.from_host(PROXY)
    return server


@pytest.mark.parametrize(
    ("header", "form"), [("x-forwarded-for", "{}"), ("forwarded", 'proto=https;for="{}:4711";by=10.0.0.1')]
)
def test_clients_behind_a_trusted_proxy_have_budgets_of_their_own(
    tmp_path: Path, header: str, form: str
) -> None:
    server = behind(tmp_path, forwarded_header=header)
    assert tries(server, 2, {header: form.format(CLIENT)}) == [401, 429]
    assert tries(server, 1, {header: form.format(OTHER)}) == [401]
    server.close()


def test_a_client_cannot_get_new_budgets_by_forging_the_header(tmp_path: Path) -> None:
    server = behind(tmp_path)
    assert tries(server, 1, {"x-forwarded-for": CLIENT}) == [401]
    assert tries(server, 1, {"x-forwarded-for": f"{OTHER}, {CLIENT}"}) == [429]
    assert tries(server, 1, {"x-forwarded-for": CLIENT, "forwarded": f"for={OTHER}"}) == [429]
    server.from_host(CLIENT)
    assert tries(server, 1, {"x-forwarded-for": OTHER}) == [429]
    server.close()


def test_without_trusted_proxies_the_header_is_ignored(tmp_path: Path) -> None:
    server = ServerUnderTest(tmp_path, login_tries_per_minute=1)
    server.from_host(PROXY)
    assert tries(server, 1, {"x-forwarded-for": CLIENT}) == [401]
    assert tries(server, 1, {"x-forwarded-for": OTHER}) == [429]
    server.close()


def test_another_address_of_the_same_ipv6_network_has_no_budget_of_its_own(tmp_path: Path) -> None:
    server = ServerUnderTest(tmp_path, login_tries_per_minute=1)
    answers = []
    for host in ("2001:db8::1", "2001:db8::2", "2001:db8:0:1::1"):
        server.from_host(host)
        answers += tries(server, 1)
    assert answers == [401, 429, 401]
    server.close()


def test_no_stranger_locks_an_operator_out_of_a_known_browser(tmp_path: Path) -> None:
    server = ServerUnderTest(tmp_path)
    right = {"name": "operator", "password": PASSWORD}
    server.from_host(CLIENT)
    assert server.post("/session", right).status_code == 200
    known = server.client
    statuses = []
    for number in range(30):
        server.from_host(f"203.0.113.{number}")
        statuses += tries(server, 1)
    assert statuses == [401] * 19 + [429] * 11, "guesses at one operator from everywhere have one budget"
    server.from_host(OTHER)
    assert server.post("/session", right).status_code == 429
    server.client = known
    assert tries(server, 5) == [401] * 5
    assert server.post("/session", right).status_code == 200
    server.elapse(60.0)
    server.from_host(OTHER)
    assert server.post("/session", right).status_code == 200
    server.close()


def test_guesses_from_a_known_browser_are_limited_too(tmp_path: Path) -> None:
    server = ServerUnderTest(tmp_path, login_tries_per_minute=2)
    assert server.post("/session", {"name": "operator", "password": PASSWORD}).status_code == 200
    assert tries(server, 3) == [401, 401, 429]
    server.close()


@pytest.mark.parametrize("cookie", ["x", "A" * 24, "A" * 200])
def test_a_forged_browser_cookie_opens_no_other_budget(tmp_path: Path, cookie: str) -> None:
    server = ServerUnderTest(tmp_path, login_tries_per_minute=1)
    assert tries(server, 1) == [401]
    assert tries(server, 1, {"Cookie": f"campusloop_browser={cookie}"}) == [429]
    server.close()


def test_bookings_of_a_developer_token_are_counted_apart_from_its_network(tmp_path: Path) -> None:
    server = ServerUnderTest(tmp_path, bookings_per_minute=1)
    headers = server.sign_in()
    made = server.post("/developer-tokens", {"name": "script", "scopes": ["drive"]}, headers=headers).json()
    token = {"Authorization": f"Bearer {made['secret']}"}
    ride = {"from_stop": "NN20", "to_stop": "C6"}
    assert [server.post("/rides", ride, headers=token).status_code for _ in range(2)] == [201, 429]
    assert [server.post("/rides", ride).status_code for _ in range(2)] == [201, 429]
    server.close()


def test_commands_are_limited_for_each_account_and_each_ride(tmp_path: Path) -> None:
    server = ServerUnderTest(tmp_path, commands_per_minute=2)
    one, other = (server.post("/rides", {"from_stop": "NN20", "to_stop": "C6"}).json() for _ in range(2))
    call = {"text": "Hello?"}
    assert [server.post(f"/rides/{one['token']}/help", call).status_code for _ in range(3)] == [201, 201, 429]
    assert server.post(f"/rides/{other['token']}/help", call).status_code == 201
    server.close()
