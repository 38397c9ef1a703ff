"""Mail between processes, on kernels whose sockets queue a few datagrams only."""

from pathlib import Path

from vehicle_agent.runtime.processes.mailbox import WAITING_MAX, Commands, Mail, Mailbox
from vehicle_agent.signals import CanFrame


def mail(number: int) -> Mail:
    return Commands((CanFrame(number, 0x100, b"\x00"),))


def numbers(received: list[Mail]) -> list[int]:
    return [one.frames[0].stamp_ns for one in received if isinstance(one, Commands)]


def exchange(sender: Mailbox, receiver: Mailbox, rounds: int) -> list[int]:
    """The numbers that the receiver takes while the sender looks for its own mail."""
    received: list[int] = []
    for _ in range(rounds):
        received += numbers(receiver.take())
        sender.take()
    return received


def test_mail_waits_at_its_sender_while_the_receiver_has_no_room(tmp_path: Path) -> None:
    sender, receiver = Mailbox(tmp_path / "gate"), Mailbox(tmp_path / "tick")
    count = 200
    assert all(sender.post(receiver.path, mail(number)) for number in range(count))
    assert exchange(sender, receiver, count) == list(range(count))
    assert (sender.lost, sender.has_waiting) == (0, False)
    sender.close(), receiver.close()


def test_a_receiver_that_takes_nothing_loses_the_oldest_mail(tmp_path: Path) -> None:
    sender, receiver = Mailbox(tmp_path / "gate"), Mailbox(tmp_path / "tick")
    count = 0
    while sender.lost == 0 and count < 20_000:
        sender.post(receiver.path, mail(count))
        count += 1
    assert sender.lost == 1
    received = exchange(sender, receiver, WAITING_MAX)
    queued = count - 1 - WAITING_MAX
    assert received == [*range(queued), *range(queued + 1, count)]
    sender.close(), receiver.close()


def test_a_process_that_is_gone_loses_its_mail(tmp_path: Path) -> None:
    sender, receiver = Mailbox(tmp_path / "gate"), Mailbox(tmp_path / "tick")
    receiver.close()
    assert not sender.post(receiver.path, mail(1))
    again = Mailbox(receiver.path)
    assert sender.post(receiver.path, mail(2))
    assert numbers(again.take()) == [2]
    assert sender.lost == 1
    sender.close(), again.close()
