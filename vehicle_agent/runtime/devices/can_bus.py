"""A vehicle's CAN bus: SocketCAN on a vehicle, IP multicast on the loopback for a simulated one."""

import can


class CanBusError(Exception):
    """The bus cannot be opened; the message says what to do."""


def open_bus(channel: str) -> can.BusABC:
    """The bus of a channel: a SocketCAN interface ("can0"), or "udp:ADDRESS:PORT" of a simulated bus.

    Simulated buses on one machine need different ports: Linux delivers a port's datagrams of every joined
    group to every socket that is bound to it. Raises CanBusError.
    """
    if not channel.startswith("udp:"):
        return _open_socketcan(channel)
    _, address, port = channel.split(":")
    try:
        return can.Bus(interface="udp_multicast", channel=address, port=int(port), hop_limit=0)
    except (OSError, can.CanError) as error:
        raise CanBusError(
            f"no multicast on this machine for {channel} ({error}). Give the loopback interface a route: "
            f"ip route add 239.0.0.0/8 dev lo"
        ) from error


def _open_socketcan(channel: str) -> can.BusABC:
    try:
        return can.Bus(interface="socketcan", channel=channel, receive_own_messages=False)
    except (OSError, can.CanError) as error:
        raise CanBusError(
            f"cannot open {channel} ({error}). Is it up? ip link set {channel} up type can bitrate 500000"
        ) from error
