"""Commands of operators and developers to a vehicle, and taps of passengers."""

from typing import Literal

from contract.geometry import Pose2
from contract.wire.base import Message
from contract.wire.bounds import Count, Id, LongText, StampNs

CommandKind = Literal[
    "hold",
    "resume",
    "announce",
    "stop_now",
    "mark",
    "start_recording",
    "stop_recording",
    "show_scene",
    "set_position",
    "show_camera",
]
# Kinds that came later: only an agent whose hello says that it understands them can read them.
LATER_KINDS: tuple[CommandKind, ...] = (
    "mark",
    "start_recording",
    "stop_recording",
    "show_scene",
    "set_position",
    "show_camera",
)


class Command(Message, frozen=True, tag="command"):
    """An operator's or developer's word to one vehicle. Repeats of a command_id are harmless.

    text     announcement, reason of a hold, note of a mark, name of a recording or of a camera
    pose_map  of `set_position`: where the vehicle stands and looks, in the map's frame
    made_ns  when it was given, by the server's clock; 0 if that is not known
    text_zh  an announcement in Chinese, `text` then being English; "" for one in a single language
    shown_until_ns  until when an announcement stays on the screens, by the server's clock; 0: it is only
             said. One with an empty text takes down what they show
    """

    epoch: Count
    command_id: Id
    kind: CommandKind
    text: LongText = ""
    made_ns: StampNs = 0
    text_zh: LongText = ""
    shown_until_ns: StampNs = 0
    pose_map: Pose2 | None = None


class PassengerTap(Message, frozen=True, tag="passenger_tap"):
    """A passenger tapped on the phone. The vehicle accepts it only while it stands with doors open."""

    epoch: Count
    tap_id: Id
    ride_id: Id
    kind: Literal["board", "alight"]
