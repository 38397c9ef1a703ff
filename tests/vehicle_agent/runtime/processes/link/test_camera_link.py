"""A camera's words by datagram on the vehicle's own network."""

import socket
import time

import pytest

from contract.wire.codec import encode
from contract.wire.messages import PresenceReport
from vehicle_agent.device_feed import DeviceFeedError
from vehicle_agent.runtime.processes.link.camera_link import REPORTS_MAX, CameraLink
from vehicle_agent.signals import InboxBody, PedestrianPresence

HOST = "127.0.0.1"


def heard(link: CameraLink, *datagrams: bytes) -> list[tuple[str, InboxBody]]:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as camera:
        for data in datagrams:
            camera.sendto(data, (HOST, link.port))
    return link.poll()


def test_a_word_is_stamped_with_when_it_was_seen() -> None:
    link = CameraLink(f"{HOST}:0")
    ((source, word),) = heard(link, encode(PresenceReport("zebra", 2, 0.5)))
    assert source == "camera"
    assert isinstance(word, PedestrianPresence)
    assert (word.area_id, word.count) == ("zebra", 2)
    assert (time.monotonic_ns() - word.stamp_ns) * 1e-9 == pytest.approx(0.5, abs=0.2)
    link.close()


def test_what_is_no_word_is_counted_and_passed_by() -> None:
    link = CameraLink(f"{HOST}:0")
    found = heard(link, b"\xff\x00", b"[" * 1900, b"{}", encode(PresenceReport("zebra", 0)))
    assert len(found) == 1
    assert link.malformed == 3
    link.close()


def test_a_flood_is_taken_in_portions() -> None:
    link = CameraLink(f"{HOST}:0")
    assert len(heard(link, *[encode(PresenceReport("zebra", 1))] * (REPORTS_MAX + 10))) == REPORTS_MAX
    link.close()


@pytest.mark.parametrize("address", ["nonsense", "127.0.0.1:99999", "300.1.1.1:5", ""])
def test_an_address_that_cannot_be_opened_is_refused(address: str) -> None:
    with pytest.raises(DeviceFeedError):
        CameraLink(address)
