"""The topics of changes, published after a commit. Payloads name what has changed."""


def vehicle_outbox(campus_id: str, vehicle_id: str) -> str:
    """The vehicle has something to be sent: order, grants, command or tap."""
    return f"campus/{campus_id}/vehicle/{vehicle_id}/outbox"


def vehicle_session(campus_id: str, vehicle_id: str) -> str:
    """A session of the vehicle was opened (field `epoch`): older ones, wherever they are, must close.

    key_conflict  1 if that is because two agents use its key
    """
    return f"campus/{campus_id}/vehicle/{vehicle_id}/session"


def vehicle(campus_id: str, vehicle_id: str) -> str:
    """The vehicle's facts or plan changed (not its position)."""
    return f"campus/{campus_id}/vehicle/{vehicle_id}/state"


def vehicle_live(campus_id: str, vehicle_id: str) -> str:
    """A position as it came in, before it is stored: the payload is the wire's Status."""
    return f"campus/{campus_id}/vehicle/{vehicle_id}/live"


def vehicle_event(campus_id: str, vehicle_id: str) -> str:
    """Something has happened on the vehicle and is stored: the payload is the wire's EventReport."""
    return f"campus/{campus_id}/vehicle/{vehicle_id}/event"


def vehicle_scene(campus_id: str, vehicle_id: str) -> str:
    """What the vehicle sees, for an operator who asked for it: the payload is the wire's OnboardScene."""
    return f"campus/{campus_id}/vehicle/{vehicle_id}/scene"


def vehicle_camera(campus_id: str, vehicle_id: str) -> str:
    """What its cameras see, for an operator who asked for it: the payload is the wire's CameraPicture."""
    return f"campus/{campus_id}/vehicle/{vehicle_id}/camera"


def area_presence(campus_id: str, area_id: str) -> str:
    """A camera's report on an observation area as it arrived: the payload is an `AreaPresence`."""
    return f"campus/{campus_id}/area/{area_id}/presence"


def ride(campus_id: str, ride_id: str) -> str:
    return f"campus/{campus_id}/ride/{ride_id}"


def incidents(campus_id: str) -> str:
    return f"campus/{campus_id}/incidents"


def sections(campus_id: str) -> str:
    """A section became free or a vehicle appeared: waiting vehicles may get further now."""
    return f"campus/{campus_id}/sections"


def dispatch(campus_id: str) -> str:
    """A ride or a departure needs a vehicle."""
    return f"campus/{campus_id}/dispatch"


def runs(campus_id: str) -> str:
    return f"campus/{campus_id}/runs"


def service(campus_id: str) -> str:
    """The service's days or hours have changed."""
    return f"campus/{campus_id}/service"


def closures(campus_id: str) -> str:
    """A road was closed or opened."""
    return f"campus/{campus_id}/closures"


def announcements(campus_id: str) -> str:
    """An announcement to riders was made, has begun or was ended."""
    return f"campus/{campus_id}/announcements"


def series(campus_id: str, series_id: str) -> str:
    """A recurring booking or one of its days has changed."""
    return f"campus/{campus_id}/series/{series_id}"


def access(campus_id: str) -> str:
    """A session or a token has ended: connections that were opened with it must end."""
    return f"campus/{campus_id}/access"


def campus_map(campus_id: str) -> str:
    """Another map has become the active one."""
    return f"campus/{campus_id}/map"


def everything(campus_id: str) -> str:
    """A pattern for all topics of a campus."""
    return f"campus/{campus_id}/>"


def scans(campus_id: str) -> str:
    """A request for scans or a proposed map has changed."""
    return f"campus/{campus_id}/scans"
