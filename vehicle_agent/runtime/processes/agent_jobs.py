"""Which processes vehicles need, by their files."""

from importlib.util import find_spec

import structlog

from vehicle_agent.runtime.processes.agent import (
    AgentPlace,
    run_gate,
    run_hmi_devices,
    run_lidars,
    run_links,
    run_localization,
    run_people_camera,
    run_planner,
    run_receivers,
    run_scanners,
    run_scans,
    run_screen,
    run_tick,
    run_video,
    run_worker,
)
from vehicle_agent.runtime.processes.agent_files import AgentFolder
from vehicle_agent.runtime.processes.supervisor import Job
from vehicle_agent.runtime.video.library import is_installed
from vehicle_agent.runtime.video.people_camera import PeopleCamera
from vehicle_agent.stacks.choice import PLANNING_STACKS, worker_tracks

log = structlog.get_logger()


def agent_jobs(places: tuple[AgentPlace, ...]) -> list[Job]:
    """The processes of these vehicles, in starting order: the gates come first.

    A vehicle whose stack plans beside the tick has its own planner, and one with a point map its own
    localization worker.
    """
    names = [AgentFolder(place.folder).vehicle().vehicle_id for place in places]
    planners = [
        Job(f"planner {name}", run_planner, (place,))
        for name, place in zip(names, places, strict=True)
        if AgentFolder(place.folder).profile().stack in PLANNING_STACKS
    ]
    localizers = [
        Job(f"localization {name}", run_localization, (place,))
        for name, place in zip(names, places, strict=True)
        if AgentFolder(place.folder).localizes_by() is not None
    ]
    gates = [Job(f"gate {name}", run_gate, (place,)) for name, place in zip(names, places, strict=True)]
    ticks = [Job(f"tick {name}", run_tick, (place,)) for name, place in zip(names, places, strict=True)]
    hmi_jobs = [
        Job(f"speaking {name}", run_hmi_devices, (place,))
        for name, place in zip(names, places, strict=True)
        if AgentFolder(place.folder).hmi_devices() is not None
    ]
    screens = [
        Job(f"screen {name}", run_screen, (place,))
        for name, place in zip(names, places, strict=True)
        if AgentFolder(place.folder).screen() is not None
    ]
    return [
        *gates,
        Job("link", run_links, (places,)),
        *worker_jobs(places),
        Job("scans", run_scans, (places,)),
        *sensor_jobs(places),
        *hmi_jobs,
        *screens,
        *planners,
        *localizers,
        *ticks,
    ]


def sensor_jobs(places: tuple[AgentPlace, ...]) -> list[Job]:
    """The processes that read sensors or record cameras, of the vehicles that have a file of these."""
    jobs = []
    for place in places:
        files = AgentFolder(place.folder)
        settings, name = files.sensors(), files.vehicle().vehicle_id
        if settings is not None and settings.lidars:
            jobs.append(Job(f"lidars {name}", run_lidars, (place,)))
        if settings is not None and settings.addresses:
            jobs.append(Job(f"receivers {name}", run_receivers, (place,)))
        if settings is not None and settings.scanners:
            jobs.append(Job(f"scanners {name}", run_scanners, (place,)))
        camera = files.people_camera()
        if camera is not None and (lacks := _camera_lacks(camera)):
            log.error("camera.not_read", vehicle_id=name, reason=lacks)
        elif camera is not None:
            jobs.append(Job(f"camera {name}", run_people_camera, (place,)))
        if files.cameras() is not None and not is_installed():
            log.error(
                "video.not_recorded", vehicle_id=name, reason="PyAV is missing: install it with `make video`"
            )
        elif files.cameras() is not None:
            jobs.append(Job(f"video {name}", run_video, (place,)))
    return jobs


def _camera_lacks(camera: PeopleCamera) -> str:
    """Which library is missing to read it, and how to install that; "": none."""
    if not is_installed():
        return "PyAV is missing: install it with `make video`"
    if camera.lens is not None and find_spec("cv2") is None:
        return "OpenCV is missing, which takes out the lens: install it with `make camera`"
    return ""


def worker_jobs(places: tuple[AgentPlace, ...]) -> list[Job]:
    """Vehicles that find road users by themselves have a worker each; the others' cells are one's work."""
    jobs, others = [], []
    for place in places:
        files = AgentFolder(place.folder)
        if worker_tracks(files.profile()):
            name = f"worker {files.vehicle().vehicle_id}"
            jobs.append(Job(name, run_worker, ((place,), name)))
        else:
            others.append(place)
    return [*jobs, Job("worker", run_worker, (tuple(others),))] if others else jobs
