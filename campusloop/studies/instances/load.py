"""Loads an instance in any of the published formats; the format is detected from the text."""

from pathlib import Path

from campusloop.studies.instances.berbeglia import instance_from_json
from campusloop.studies.instances.cordeau import instance_from_cordeau
from campusloop.studies.instances.instance import Instance, InstanceBroken
from campusloop.studies.instances.li_lim import instance_from_li_lim

_LI_LIM_HEADER = 3
_CORDEAU_HEADER = 5


def load_instance(path: Path) -> Instance:
    """The instance in a file of Cordeau's, Berbeglia's or Li & Lim's format.

    Raises InstanceBroken, naming file and line; OSError where the file cannot be read.
    """
    try:
        text = path.read_text(encoding="utf-8")
    except UnicodeDecodeError as error:
        raise InstanceBroken(f"{path.name}: not a text file") from error
    if path.suffix == ".json" or text.lstrip().startswith("{"):
        return instance_from_json(path.stem, text)
    header = text.split("\n", 1)[0].split()
    if len(header) == _LI_LIM_HEADER:
        return instance_from_li_lim(path.stem, text)
    if len(header) == _CORDEAU_HEADER:
        return instance_from_cordeau(path.stem, text)
    raise InstanceBroken(
        f"{path.name}: the first line has {len(header)} numbers; dial-a-ride files (Cordeau) begin "
        "with five, pickup-and-delivery files (Li & Lim) with three"
    )
