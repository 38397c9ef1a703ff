"""Who a client is: behind proxies the right-most address that none of them has, in budgets its network."""

import pytest

from server.addresses import address_of, budget_of, client_of, host_of, hosts_of, is_in, networks_of

PROXIES = networks_of("10.0.0.0/8, fd00::/8, 127.0.0.1")


@pytest.mark.parametrize(
    ("text", "address"),
    [
        ("192.0.2.7", "192.0.2.7"),
        (" 192.0.2.7:4711 ", "192.0.2.7"),
        ("[2001:db8::1]:80", "2001:db8::1"),
        ("2001:db8::1", "2001:db8::1"),
        ("fe80::1%eth0", "fe80::1"),
        ("::ffff:192.0.2.7", "192.0.2.7"),
    ],
)
def test_an_address_is_read_however_it_is_written(text: str, address: str) -> None:
    assert str(address_of(text)) == address


@pytest.mark.parametrize("text", ["", "unknown", "_hidden", "192.0.2.256", "a:b", "[", "1.2.3.4, 5.6.7.8"])
def test_anything_else_is_no_address(text: str) -> None:
    assert address_of(text) is None


def test_all_addresses_of_one_ipv6_network_share_a_budget() -> None:
    assert budget_of("2001:db8:0:1::1") == budget_of("2001:db8:0:1:ffff::9") == "2001:db8:0:1::/64"
    assert budget_of("2001:db8:0:2::1") != budget_of("2001:db8:0:1::1")


def test_ipv4_addresses_have_budgets_of_their_own_also_as_ipv6_addresses() -> None:
    assert budget_of("192.0.2.7") == budget_of("::ffff:192.0.2.7") == "192.0.2.7"
    assert budget_of("192.0.2.8") != budget_of("192.0.2.7")
    assert budget_of("testclient") == "testclient"


def test_the_client_is_the_right_most_address_that_no_proxy_has() -> None:
    assert client_of("10.0.0.1", ["192.0.2.7"], PROXIES) == "192.0.2.7"
    assert client_of("10.0.0.1", ["192.0.2.7", "10.0.0.2", "fd00::3"], PROXIES) == "192.0.2.7"


def test_what_the_client_itself_wrote_into_the_header_is_not_believed() -> None:
    assert client_of("10.0.0.1", ["203.0.113.9", "192.0.2.7"], PROXIES) == "192.0.2.7"
    assert client_of("10.0.0.1", ["10.0.0.9", "192.0.2.7"], PROXIES) == "192.0.2.7"


def test_the_word_of_a_peer_that_is_no_proxy_is_not_believed() -> None:
    assert client_of("192.0.2.7", ["203.0.113.9"], PROXIES) == "192.0.2.7"
    assert client_of("10.0.0.1", ["203.0.113.9"], ()) == "10.0.0.1"


@pytest.mark.parametrize("hops", [[], ["unknown"], ["192.0.2.7", "garbage"]])
def test_a_header_that_says_nothing_leaves_the_proxys_address(hops: list[str]) -> None:
    assert client_of("10.0.0.1", hops, PROXIES) == "10.0.0.1"


def test_behind_proxies_alone_the_farthest_one_is_the_client() -> None:
    assert client_of("10.0.0.1", ["10.0.0.3", "10.0.0.2"], PROXIES) == "10.0.0.3"


def test_names_are_in_no_network() -> None:
    assert not is_in("testclient", PROXIES)
    assert is_in("10.255.0.1", PROXIES)


@pytest.mark.parametrize("text", ["10.0.0.1/8", "example.org", "10.0.0.0/33"])
def test_what_is_no_network_is_refused(text: str) -> None:
    with pytest.raises(ValueError):  # noqa: PT011 - the text is the library's
        networks_of(text)


def test_host_names_are_read_without_port_case_and_final_dot() -> None:
    assert [host_of(text) for text in ("Example.org:80", "[::1]:8080", "example.org.")] == [
        "example.org",
        "::1",
        "example.org",
    ]


@pytest.mark.parametrize("text", ["https://example.org", "a.*.org", "*."])
def test_what_is_no_host_name_is_refused(text: str) -> None:
    with pytest.raises(ValueError, match="is no host name"):
        hosts_of(text)
