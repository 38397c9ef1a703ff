"""Browsers that asked for it hear of their ride: each notice once, encrypted, and in their language."""

import asyncio
import contextlib
import socket
from collections.abc import Iterator
from datetime import datetime, timedelta

import pytest
from sqlalchemy import Engine

from server import webhook_sender
from server.addresses import LOOPBACK
from server.domain.errors import PushSubscriptionInvalid, RideEnded
from server.domain.rides.notices import ENDED_FOR_S, NEAR_S, PAUSES_S, Language, PushSubscription
from server.domain.rides.rides import Promise, Ride, RideState, promised_anew
from server.loops.ride_notices import RideNotices
from server.push_encryption import PushIdentity
from server.push_sender import WebPushSender
from server.usecases.ports.push import PushAnswer, PushMessage
from server.usecases.rides import erasure, notices, rides
from server.usecases.rides.notices import PER_SERVICE_MAX, SUBSCRIPTIONS_PER_RIDE_MAX
from server.webhook_sender import HttpWebhookSender
from tests.server.push_service import PushService, claims_of, serving
from tests.server.usecases.campus_under_test import CampusUnderTest
from tests.server.usecases.fake_fleet import FakeFleet
from tests.server.usecases.shipped_maps import shipped_map

IDENTITY = PushIdentity(b"a secret of thirty-two bytes, all")
ELSEWHERE = "https://push.example/send/"


@pytest.fixture
def stored_fleet(engine: Engine) -> Iterator[FakeFleet]:
    """On SQLite and on PostgreSQL."""
    campus = CampusUnderTest(shipped_map("snow-lion"), engine=engine)
    yield FakeFleet(campus, shipped_map("snow-lion"), 2).start()
    campus.close()


@pytest.fixture
def fleet() -> Iterator[FakeFleet]:
    campus = CampusUnderTest(shipped_map("snow-lion"))
    yield FakeFleet(campus, shipped_map("snow-lion"), 2).start()
    campus.close()


def want(
    fleet: FakeFleet, ride: Ride, service: PushService, language: Language = "en", endpoint: str = ""
) -> None:
    wish = service.browser.subscription(endpoint or service.endpoint)
    fleet.campus.do(
        lambda uow: notices.subscribe(
            uow, ride, wish["endpoint"], wish["p256dh"], wish["auth"], language, may_be_plain=True
        )
    )


def kept(fleet: FakeFleet) -> int:
    return fleet.campus.read(lambda uow: len(uow.push_subscriptions.all()))


class MuteService:
    """A push service that takes connections and never answers."""

    def __init__(self) -> None:
        self._socket = socket.create_server(("127.0.0.1", 0), backlog=100)
        self._socket.setblocking(False)
        self.endpoint = f"http://127.0.0.1:{self._socket.getsockname()[1]}/none"

    def asked(self) -> int:
        """How many connections have been made so far."""
        count = 0
        with contextlib.suppress(BlockingIOError):
            while True:
                self._socket.accept()[0].close()
                count += 1
        return count

    def close(self) -> None:
        self._socket.close()


def cycle(fleet: FakeFleet, service: PushService, times: int = 1) -> None:
    """The push service runs on the same loop as the server's task: it is asked as over a network."""

    async def run() -> None:
        http = HttpWebhookSender(LOOPBACK)
        sender = WebPushSender(IDENTITY, http, "mailto:ops@example.org")
        task = RideNotices(fleet.campus.transactions, sender, fleet.campus.clock)
        address = service.origin.rpartition(":")[2]
        server = await asyncio.start_server(service.serve, "127.0.0.1", int(address))
        async with server:
            for _ in range(times):
                await task.run_once()
            await task.end()
        await http.close()

    asyncio.run(run())


@pytest.fixture
def service() -> PushService:
    made = PushService()

    async def find_port() -> None:
        async with serving(made):
            pass

    asyncio.run(find_port())
    return made


def test_a_ride_from_near_to_here_is_told_once_each_in_the_riders_language(
    fleet: FakeFleet, service: PushService
) -> None:
    ride = fleet.book("NN20", "C6")
    want(fleet, ride, service, "zh")
    while fleet.ride(ride.ride_id).state is RideState.ASSIGNED:
        fleet.step()
        cycle(fleet, service)
    cycle(fleet, service, times=3)
    name = fleet.campus.read(lambda uow: uow.vehicles.get(ride.vehicle_id or "")).name
    first, second = service.notices
    assert first["title"].startswith(f"{name} 约 ")
    assert second["title"] == f"{name} 已到站"
    assert first["tag"] == second["tag"], "the second is shown in place of the first"
    assert first["language"] == "zh"
    token = fleet.campus.secrets_of(ride).token
    assert first["address"] == second["address"] == f"/#ride={token}"
    headers = service.headers[0]
    assert (headers["ttl"], headers["urgency"], headers["content-encoding"]) == ("180", "high", "aes128gcm")
    claims = claims_of(headers["authorization"])
    assert (claims["aud"], claims["key"]) == (service.origin, IDENTITY.public_key)
    fleet.run_until(lambda: fleet.ride(ride.ride_id).has_ended)
    cycle(fleet, service)
    assert (len(service.notices), kept(fleet)) == (2, 0), "a completed ride is told by nothing, and forgotten"


def test_a_shuttle_is_near_when_it_is_expected_in_three_minutes(
    fleet: FakeFleet, service: PushService
) -> None:
    ride = fleet.book("NN20", "C6", earliest=fleet.campus.clock.now() + timedelta(minutes=10))
    want(fleet, ride, service)

    def ahead_s() -> float:
        eta = fleet.ride(ride.ride_id).pickup_eta or ride.earliest
        return (eta - fleet.campus.clock.now()).total_seconds()

    fleet.run_until(lambda: ahead_s() < NEAR_S + 5.0)
    cycle(fleet, service)
    assert service.attempts == 0
    fleet.run_until(lambda: ahead_s() <= NEAR_S)
    cycle(fleet, service)
    (notice,) = service.notices
    assert "arrives in about 3 minutes" in notice["title"]


def test_a_new_promise_and_a_cancellation_by_the_operator_are_told(
    stored_fleet: FakeFleet, service: PushService
) -> None:
    campus = stored_fleet.campus
    ride = stored_fleet.book("NN20", "C6", earliest=campus.clock.now() + timedelta(hours=2))
    want(stored_fleet, ride, service)
    cycle(stored_fleet, service)
    assert service.attempts == 0, "the page showed the first promise"
    later = ride.earliest + timedelta(minutes=20)
    promise = Promise(later, later + timedelta(minutes=6), later + timedelta(minutes=20))
    campus.do(lambda uow: uow.rides.save(promised_anew(ride, promise)))
    cycle(stored_fleet, service, times=2)
    campus.do(lambda uow: rides.cancel(uow, ride.ride_id, "operator"))
    cycle(stored_fleet, service, times=2)
    assert [notice["title"] for notice in service.notices] == [
        "Your ride has changed",
        "Your ride was cancelled",
    ]
    assert service.notices[1]["body"].startswith("The operators cancelled it.")
    assert kept(stored_fleet) == 0


def test_who_cancels_a_ride_hears_nothing_of_it(fleet: FakeFleet, service: PushService) -> None:
    ride = fleet.book("NN20", "C6")
    want(fleet, ride, service)
    fleet.campus.do(lambda uow: rides.cancel(uow, ride.ride_id, "passenger"))
    cycle(fleet, service)
    assert (service.attempts, kept(fleet)) == (0, 0)


def test_what_does_not_arrive_is_tried_again_after_a_pause(fleet: FakeFleet, service: PushService) -> None:
    ride = fleet.book("NN20", "C6")
    want(fleet, ride, service)
    service.statuses = [503, 429]
    fleet.campus.do(lambda uow: rides.cancel(uow, ride.ride_id, "operator"))
    for pause_s in PAUSES_S[:2]:
        cycle(fleet, service, times=2)
        assert service.notices == []
        fleet.campus.clock.advance(pause_s)
    cycle(fleet, service, times=2)
    assert (service.attempts, len(service.notices), kept(fleet)) == (3, 1, 0)


def test_a_push_service_that_never_answers_is_given_up_after_an_hour(
    fleet: FakeFleet, service: PushService
) -> None:
    ride = fleet.book("NN20", "C6")
    want(fleet, ride, service)
    fleet.campus.do(lambda uow: rides.cancel(uow, ride.ride_id, "operator"))
    service.statuses = [500] * 100
    cycle(fleet, service)
    assert kept(fleet) == 1
    fleet.campus.clock.advance(ENDED_FOR_S)
    cycle(fleet, service)
    assert (service.attempts, kept(fleet)) == (1, 0)


@pytest.mark.parametrize("status", [404, 410])
def test_a_browser_that_is_gone_is_forgotten(fleet: FakeFleet, service: PushService, status: int) -> None:
    ride = fleet.book("NN20", "C6")
    want(fleet, ride, service)
    fleet.campus.do(lambda uow: rides.cancel(uow, ride.ride_id, "operator"))
    service.statuses = [status]
    cycle(fleet, service)
    assert (service.attempts, kept(fleet)) == (1, 0)


def test_a_silent_push_service_does_not_hold_the_others(
    fleet: FakeFleet, service: PushService, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(webhook_sender, "ATTEMPT_S_MAX", 60.0)
    mute = MuteService()
    silent = [fleet.book("NN20", "C6") for _ in range(PER_SERVICE_MAX + 2)]
    for ride in silent:
        want(fleet, ride, service, endpoint=mute.endpoint)
    heard = fleet.book("NN20", "C6")
    want(fleet, heard, service)
    for ride in (*silent, heard):
        fleet.campus.do(lambda uow, ride=ride: rides.cancel(uow, ride.ride_id, "operator"))
    cycle(fleet, service)
    assert len(service.notices) == 1
    assert mute.asked() == PER_SERVICE_MAX, "none of them has been answered yet"
    mute.close()


def test_two_servers_send_a_notice_once(stored_fleet: FakeFleet, service: PushService) -> None:
    ride = stored_fleet.book("NN20", "C6")
    want(stored_fleet, ride, service)
    stored_fleet.campus.do(lambda uow: rides.cancel(uow, ride.ride_id, "operator"))
    found, over = stored_fleet.campus.read(notices.due)
    first = stored_fleet.campus.do(lambda uow: notices.claim(uow, found, over))
    second = stored_fleet.campus.do(lambda uow: notices.claim(uow, found, over))
    assert (len(first), second) == (1, [])


def test_the_subscription_is_erased_with_the_rider(fleet: FakeFleet, service: PushService) -> None:
    ride = fleet.book("NN20", "C6")
    want(fleet, ride, service)
    fleet.campus.do(lambda uow: rides.cancel(uow, ride.ride_id, "operator"))
    fleet.campus.do(lambda uow: erasure.erase_ride(uow, ride.ride_id, "ann"))
    assert kept(fleet) == 0


def test_a_ride_has_so_many_browsers_and_the_oldest_goes(
    stored_fleet: FakeFleet, service: PushService
) -> None:
    ride = stored_fleet.book("NN20", "C6")
    for number in range(SUBSCRIPTIONS_PER_RIDE_MAX + 1):
        stored_fleet.campus.clock.advance(1.0)
        want(stored_fleet, ride, service, endpoint=f"{ELSEWHERE}{number}")
    want(stored_fleet, ride, service, endpoint=f"{ELSEWHERE}{SUBSCRIPTIONS_PER_RIDE_MAX}")
    stored = stored_fleet.campus.read(lambda uow: uow.push_subscriptions.of_ride(ride.ride_id))
    assert [one.endpoint[-1] for one in stored] == ["1", "2", "3", "4", "5"]
    stored_fleet.campus.do(lambda uow: notices.unsubscribe(uow, ride, stored[0].subscription_id))
    assert kept(stored_fleet) == SUBSCRIPTIONS_PER_RIDE_MAX - 1


@pytest.mark.parametrize("endpoint", ["ftp://push.example/x", "https://user:secret@push.example/x", "here"])
def test_an_address_that_is_none_is_refused(fleet: FakeFleet, service: PushService, endpoint: str) -> None:
    ride = fleet.book("NN20", "C6")
    with pytest.raises(PushSubscriptionInvalid):
        want(fleet, ride, service, endpoint=endpoint)


def test_a_ride_that_is_over_takes_no_subscription(fleet: FakeFleet, service: PushService) -> None:
    ride = fleet.book("NN20", "C6")
    over = fleet.campus.do(lambda uow: rides.cancel(uow, ride.ride_id, "passenger"))
    with pytest.raises(RideEnded):
        want(fleet, over, service)


class SlowSender:
    """Answers at once, but for one push service not before it is told to."""

    public_key = ""

    def __init__(self) -> None:
        self.sent: list[str] = []
        self.released = asyncio.Event()

    async def send(self, subscription: PushSubscription, message: PushMessage, now: datetime) -> PushAnswer:
        self.sent.append(subscription.endpoint)
        if "slow" in subscription.endpoint:
            await self.released.wait()
        return PushAnswer()


def test_a_push_service_that_is_slow_holds_up_only_its_own_notices(
    fleet: FakeFleet, service: PushService
) -> None:
    slow, fast = "https://slow.example/", "https://fast.example/"
    waits, first, second = (fleet.book("NN20", "C6") for _ in range(3))
    want(fleet, waits, service, endpoint=slow + "1")
    want(fleet, first, service, endpoint=fast + "1")
    sender = SlowSender()
    task = RideNotices(fleet.campus.transactions, sender, fleet.campus.clock)

    def want_and_cancel() -> None:
        want(fleet, second, service, endpoint=fast + "2")
        cancel(second)

    def cancel(ride: Ride) -> None:
        fleet.campus.do(lambda uow: rides.cancel(uow, ride.ride_id, "operator"))

    async def scenario() -> None:
        await task.run_once()
        assert sorted(sender.sent) == [fast + "1", slow + "1"]
        await asyncio.to_thread(want_and_cancel)
        await task.run_once()
        assert sender.sent[2:] == [fast + "2"], "the slow one is not asked twice meanwhile"
        sender.released.set()
        await task.run_once()
        await task.end()

    cancel(waits)
    cancel(first)
    asyncio.run(scenario())
    assert (len(sender.sent), kept(fleet)) == (3, 0)
