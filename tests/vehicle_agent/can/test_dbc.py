import os
from pathlib import Path

import cantools
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vehicle_agent.can.dbc import DBC_PATH, FrameError, layouts

OWN = cantools.database.can.Database()
OWN.add_dbc_file(DBC_PATH)
OUR_OWN_MESSAGES = {"energy_report"}


@st.composite
def messages(draw: st.DrawFn) -> tuple[str, dict[str, float]]:
    """A message of the DBC with a value within range for each of its signals."""
    name = draw(st.sampled_from(sorted(layouts())))
    values = {
        signal.name: draw(st.floats(float(signal.minimum), float(signal.maximum)))
        if signal.scale != 1
        else float(draw(st.integers(int(signal.minimum), int(signal.maximum))))
        for signal in OWN.get_message_by_name(name).signals
    }
    return name, values


def published_dbc() -> cantools.database.can.Database:
    default = Path(__file__).resolve().parents[3].parent / "shared"
    folder = Path(os.environ.get("CAMPUSLOOP_SHARED", default)) / "data" / "pacmod"
    files = sorted(folder.glob("*.dbc")) if folder.is_dir() else []
    if not files:
        pytest.skip(f"no published DBC under {folder}; set CAMPUSLOOP_SHARED")
    database = cantools.database.can.Database()
    database.add_dbc_file(files[0])
    return database


@given(messages())
def test_packing_gives_the_bytes_that_cantools_gives(message: tuple[str, dict[str, float]]) -> None:
    name, values = message
    assert layouts()[name].pack(values) == OWN.encode_message(name, values, scaling=True, strict=True)


@given(messages())
def test_unpacking_gives_the_values_that_cantools_gives(message: tuple[str, dict[str, float]]) -> None:
    name, values = message
    data = layouts()[name].pack(values)
    expected = OWN.decode_message(name, data, decode_choices=False)
    assert layouts()[name].unpack(data) == pytest.approx(expected, abs=1e-9)


@given(messages())
def test_a_value_comes_back_within_half_a_step(message: tuple[str, dict[str, float]]) -> None:
    name, values = message
    layout = layouts()[name]
    back = layout.unpack(layout.pack(values))
    for signal, value in values.items():
        assert abs(back[signal] - value) <= 0.5 * layout.signals[signal].scale + 1e-9


def test_a_value_out_of_range_is_sent_as_the_nearest_allowed_one() -> None:
    layout = layouts()["brake_command"]
    assert layout.unpack(layout.pack({"position": 7.0}))["position"] == 1.0
    assert layout.unpack(layout.pack({"position": -1.0}))["position"] == 0.0


@pytest.mark.parametrize("value", [float("nan"), float("inf"), float("-inf")])
def test_a_value_that_is_not_finite_is_refused_by_name(value: float) -> None:
    with pytest.raises(FrameError, match="position"):
        layouts()["brake_command"].pack({"position": value})


def test_a_frame_of_the_wrong_length_is_refused_by_name() -> None:
    with pytest.raises(FrameError, match="speed_report"):
        layouts()["speed_report"].unpack(b"\x00")


def test_every_message_lies_on_the_bus_as_in_the_published_dbc() -> None:
    published = published_dbc()
    for layout in layouts().values():
        if layout.name in OUR_OWN_MESSAGES:
            continue
        theirs = published.get_message_by_frame_id(layout.arbitration_id)
        assert theirs.length == layout.length
        placed = {(s.start, s.length, s.is_signed, float(s.scale), s.byte_order) for s in theirs.signals}
        for signal in OWN.get_message_by_name(layout.name).signals:
            place = (signal.start, signal.length, signal.is_signed, float(signal.scale), signal.byte_order)
            assert place in placed, f"{layout.name}.{signal.name}"


def test_our_own_message_takes_no_published_identifier() -> None:
    taken = {message.frame_id for message in published_dbc().messages}
    assert not taken & {layouts()[name].arbitration_id for name in OUR_OWN_MESSAGES}


def test_published_commands_read_back_what_we_command() -> None:
    published = published_dbc()
    data = layouts()["steering_command"].pack({"enable": 1, "wheel_angle": -3.25, "wheel_rate": 1.5})
    read = published.decode_message(300, data, decode_choices=False)
    assert read["POSITION"] == pytest.approx(-3.25)
    assert read["ROTATION_RATE"] == pytest.approx(1.5)
    assert read["ENABLE"] == 1
