"""Corrections come through whole, of either revision and in any pieces; refusals say why."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from vehicle_agent.receivers.solutions import Solution
from vehicle_agent.runtime.sensors.ntrip import NtripRefused, NtripSession, caster_of, gga_sentence

CASTER = caster_of("http://caster.example:2102/MOUNT", "me", "secret")
# The beginning of RTCM frames, and bytes that look like the end of a header.
RTCM = b"\xd3\x00\x13\x3e\xd7\r\n\r\n\xd3\x00\x00\x47\xea\x4b"


def chunked(data: bytes, size: int) -> bytes:
    parts = [data[at : at + size] for at in range(0, len(data), size)]
    return b"".join(f"{len(part):x}\r\n".encode() + part + b"\r\n" for part in parts)


ANSWERS = {
    "revision 1": b"ICY 200 OK\r\n" + RTCM,
    "revision 2": b"HTTP/1.1 200 OK\r\nNtrip-Version: Ntrip/2.0\r\nContent-Type: gnss/data\r\n\r\n" + RTCM,
    "chunked": b"HTTP/1.1 200 OK\r\nTransfer-Encoding: chunked\r\n\r\n" + chunked(RTCM, 5),
}


def test_the_request_names_mountpoint_revision_and_user() -> None:
    lines = NtripSession(CASTER).request().decode().split("\r\n")
    assert lines[0] == "GET /MOUNT HTTP/1.1"
    assert "Host: caster.example:2102" in lines
    assert "Ntrip-Version: Ntrip/2.0" in lines
    assert "Authorization: Basic bWU6c2VjcmV0" in lines
    assert lines[-2:] == ["", ""]


@given(st.sampled_from(sorted(ANSWERS)), st.lists(st.integers(1, 20), max_size=60))
def test_corrections_come_through_in_any_pieces(kind: str, cuts: list[int]) -> None:
    session, data, found, at = NtripSession(CASTER), ANSWERS[kind], b"", 0
    for cut in [*cuts, len(data)]:
        found += session.add(data[at : at + cut])
        at += cut
    assert found == RTCM
    assert session.has_begun


@pytest.mark.parametrize(
    ("answer", "says"),
    [
        (b"SOURCETABLE 200 OK\r\nServer: x\r\n", "no mountpoint 'MOUNT'"),
        (b"HTTP/1.1 200 OK\r\nContent-Type: gnss/sourcetable\r\n\r\n", "no mountpoint 'MOUNT'"),
        (b"HTTP/1.1 401 Unauthorized\r\n\r\n", "refuses user and password"),
        (b"ERROR - Bad Password\r\n", "Bad Password"),
        (b"HTTP/1.1 503 Service Unavailable\r\n\r\n", "503"),
        (b"x" * 9000, "no header"),
        (b"HTTP/1.1 200 OK\r\nTransfer-Encoding: chunked\r\n\r\nzz\r\n", "chunk of length"),
        (b"HTTP/1.1 200 OK\r\nTransfer-Encoding: chunked\r\n\r\n" + b"1" * 100, "without their length"),
    ],
)
def test_a_caster_that_gives_none_is_named_with_its_answer(answer: bytes, says: str) -> None:
    with pytest.raises(NtripRefused, match=says):
        NtripSession(CASTER).add(answer)


def test_a_url_names_host_port_and_mountpoint() -> None:
    secure = caster_of("https://caster.example/M")
    assert (secure.port, secure.is_encrypted, caster_of("http://caster.example/M").port) == (443, True, 2101)
    for url in ("caster.example/M", "http://caster.example", "http://caster.example/a/b", "ftp://c/M"):
        with pytest.raises(ValueError, match="MOUNTPOINT"):
            caster_of(url)


@pytest.mark.parametrize(
    ("latitude_deg", "longitude_deg", "says"),
    [
        (31.315, 121.39, "3118.90000,N,12123.40000,E"),
        (-33.8567844, -151.213108, "3351.40706,S,15112.78648,W"),
        # 29.999... minutes, rounded up, are no 60.
        (0.9999999999, 0.5, "0100.00000,N,00030.00000,E"),
    ],
)
def test_the_place_is_told_in_degrees_and_minutes(
    latitude_deg: float, longitude_deg: float, says: str
) -> None:
    solution = Solution(None, latitude_deg, longitude_deg, 0.0, None, None, 1.0)
    noon_ns = 1_777_896_000_000_000_000
    sentence = gga_sentence(solution, noon_ns).decode()
    assert sentence.startswith(f"$GPGGA,120000.00,{says},1,")
    pynmeagps = pytest.importorskip("pynmeagps", reason="needs the extra `workshop`")
    parsed = pynmeagps.NMEAReader.parse(sentence.encode())
    assert parsed.lat == pytest.approx(latitude_deg, abs=1e-6)
    assert parsed.lon == pytest.approx(longitude_deg, abs=1e-6)
