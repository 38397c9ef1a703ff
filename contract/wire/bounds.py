"""The bounds of every number, text and list on the wire: what a message exceeds them with is no message.

They are wide: physics and storage set them, not the shuttles of today. Integers fit a signed 64-bit column,
lengths in metres a campus, texts a screen.
"""

from typing import Annotated

from msgspec import Meta

from contract.geometry import POSITION_M_MAX
from contract.roads.model import NAME_CHARACTERS_MAX

INTEGER_MAX = 2**63 - 1
# The largest integer that a JavaScript number holds exactly (RFC 8259, section 6).
COUNT_MAX = 2**53 - 1
ID_CHARACTERS_MAX = 64
SEATS_MAX = 200

# Text. An id names a thing of ours; a place id one of the map's, which brings its own names.
Id = Annotated[str, Meta(max_length=ID_CHARACTERS_MAX)]
PlaceId = Annotated[str, Meta(max_length=NAME_CHARACTERS_MAX)]
ShortText = Annotated[str, Meta(max_length=NAME_CHARACTERS_MAX)]
LONG_CHARACTERS_MAX = 2_000
LongText = Annotated[str, Meta(max_length=LONG_CHARACTERS_MAX)]
# An unpadded Ed25519 signature has 86 characters; a nonce is ours.
Proof = Annotated[str, Meta(max_length=200)]
RideCode = Annotated[str, Meta(max_length=20)]

# Whole numbers.
Count = Annotated[int, Meta(ge=0, le=COUNT_MAX)]
StampNs = Annotated[int, Meta(ge=-INTEGER_MAX, le=INTEGER_MAX)]
ProtocolVersion = Annotated[int, Meta(ge=0, le=10_000)]
Seats = Annotated[int, Meta(ge=1, le=SEATS_MAX)]
Places = Annotated[int, Meta(ge=0, le=SEATS_MAX)]
PeopleCount = Annotated[int, Meta(ge=-1, le=10_000)]

# Quantities.
Coordinate = Annotated[float, Meta(ge=-POSITION_M_MAX, le=POSITION_M_MAX)]
ArcLength = Annotated[float, Meta(ge=-POSITION_M_MAX, le=POSITION_M_MAX)]
Distance = Annotated[float, Meta(ge=0.0, le=POSITION_M_MAX)]
BodyLength = Annotated[float, Meta(ge=0.0, le=1_000.0)]
Speed = Annotated[float, Meta(ge=-100.0, le=100.0)]
Acceleration = Annotated[float, Meta(ge=-1_000.0, le=1_000.0)]
Angle = Annotated[float, Meta(ge=-10.0, le=10.0)]
Ratio = Annotated[float, Meta(ge=-1.0, le=2.0)]
Duration = Annotated[float, Meta(ge=0.0, le=1e6)]
