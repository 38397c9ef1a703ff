"""Vehicles that send what no vehicle should send."""

import asyncio
import dataclasses

import msgspec

from benchmarks.faults.stage import Stage, require
from benchmarks.faults.wire_vehicle import WireVehicle, with_value
from contract.wire.codec import encode
from contract.wire.messages import EventReport, RiderAlighted, RiderBoarded, RiderNoShow


async def mad_seats(stage: Stage) -> None:
    """A vehicle says hello with 2**62 seats."""
    stage.first.seats = 2**62
    await stage.first.cut()
    await stage.until_incident("protocol_violation")


async def mad_speed(stage: Stage) -> None:
    """A vehicle reports a speed of -5e200 m/s, once after each connection."""
    await stage.first.say_raw(with_value(stage.first.status(), "speed_mps", b"-5e200"))
    await stage.until_incident("protocol_violation")


async def mad_stamp(stage: Stage) -> None:
    """An event's stamp has 70 bits."""
    event = EventReport(stage.first.epoch, "boot-1", 99, 1, RiderNoShow("ride-none"))
    await stage.first.say_raw(with_value(event, "stamp_ns", str(2**70).encode()))
    await stage.until_incident("protocol_violation")


async def far_position(stage: Stage) -> None:
    """A vehicle says that it is 900 km away, on a lane that does not exist."""
    status = with_value(stage.first.status(), "pose_map", b"[900000.0,900000.0,0.0]")
    for _ in range(20):
        await stage.first.say_raw(status)
        await asyncio.sleep(0.05)


async def forged_boarding(stage: Stage) -> None:
    """A vehicle says that it has boarded and let out every ride of the other one."""
    mine, other = stage.first, stage.second

    async def has_rides() -> bool:
        return bool(await _rides_of(stage, other))

    await stage.until(has_rides, "a ride of the other shuttle", 40.0)
    forged = await _rides_of(stage, other)
    for ride_id in forged:
        mine.report(RiderBoarded(ride_id, "code"))
        mine.report(RiderAlighted(ride_id, "code"))
    await stage.until_incident("false_report")
    rides = {ride["ride_id"]: ride for ride in await stage.installation.ask("GET", "/rides?limit=200")}
    moved = [ride_id for ride_id in forged if rides[ride_id]["state"] in ("aboard", "completed")]
    require(not moved, f"{len(moved)} rides moved by another vehicle's word")


async def two_agents_with_one_key(stage: Stage) -> None:
    """A second agent with the same key runs for 10 s: both are refused, with one incident."""
    twin = dataclasses.replace(stage.first, boot_id="boot-of-the-twin", goodbyes=[], orders=[])
    running = asyncio.create_task(twin.run())
    await asyncio.sleep(10.0)
    running.cancel()
    await asyncio.gather(running, return_exceptions=True)
    conflicts = (await stage.open_incidents()).count("key_conflict")
    require(conflicts == 1, f"{conflicts} incidents of two agents with one key")
    vehicle = await stage.installation.ask("GET", f"/vehicles/{stage.first.vehicle_id}")
    require(not vehicle["connected"], "one of two agents with one key is served")


async def frames_that_are_no_messages(stage: Stage) -> None:
    """Broken JSON, other types, deep nesting, 600 KB: one connection each."""
    for data in (b"{", b"[]", b'{"type":"teleport"}', b"[" * 5000, b" " * 600_000, b'{"type":"status"}'):
        await stage.first.say_raw(data)
        await asyncio.sleep(0.3)


async def flood_of_frames(stage: Stage) -> None:
    """20,000 statuses as fast as the socket takes them."""
    data = encode(stage.first.status())
    for _ in range(20_000):
        await stage.first.say_raw(data)


async def connections_cut(stage: Stage) -> None:
    """A vehicle's connection is cut 20 times."""
    for _ in range(20):
        await stage.first.cut()
        await asyncio.sleep(0.6)
    await stage.first.until_served()


async def vehicle_clock_jumps(stage: Stage) -> None:
    """A vehicle's clock jumps by years, back and forth, in statuses and events: it is served all the same."""
    vehicle = stage.first
    for stamp_ns in (1, 2**62, 0, 2**40, 2**62, 5):
        await vehicle.say(msgspec.structs.replace(vehicle.status(), stamp_ns=stamp_ns))
        await asyncio.sleep(0.3)
    await vehicle.until_served()
    require("protocol_violation" not in await stage.open_incidents(), "a stamp counts as a violation")


async def gaps_and_repeats(stage: Stage) -> None:
    """Events come with gaps, in the wrong order and many times: each is stored once and in its place."""
    vehicle = stage.first
    for number in range(40):
        vehicle.events.append(stage.an_event(number))
    for sequence in (9, 3, 3, 1, 39, 2, 2, 2, 0, 20, 1):
        event = vehicle.events[sequence]
        await vehicle.say(EventReport(vehicle.epoch, vehicle.boot_id, sequence, sequence + 1, event))
    await vehicle.cut()

    async def all_stored() -> bool:
        return vehicle.acknowledged >= len(vehicle.events)

    await stage.until(all_stored, "all events are acknowledged", 30.0)


async def vehicle_that_does_not_read(stage: Stage) -> None:
    """A vehicle's computer reads nothing for 15 s, and then dials again."""
    await stage.first.freeze(15.0)
    await stage.first.redial()


async def _rides_of(stage: Stage, vehicle: WireVehicle) -> list[str]:
    rides = await stage.installation.ask("GET", f"/rides?vehicle_id={vehicle.vehicle_id}&limit=50")
    return [ride["ride_id"] for ride in rides if ride["state"] in ("assigned", "boarding")]
