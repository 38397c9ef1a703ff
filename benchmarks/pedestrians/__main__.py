"""People by laser and camera (NUS): `python -m benchmarks.pedestrians [--video F] [--json F]`.

rate         scans with a picture each in a second of one core's processor time, when every one of 10 and 40
             candidates is looked at every time (in a drive, verified people are in one picture of eight)
recall       people in simulated drives on seeds that nothing was tuned on, by range: share of the pictures in
             which a person who has been in view for a second has a track (tracked_pct) with a person's label
             (recall_pct). In view: whole in the picture, and less than 40 % hidden
false        tracks among trees that sway, without people: labelled as people (false_per_min), called moving
             (moving_per_min); most of the driving is without pictures, of which labels say nothing
recognition  share of people whose region OpenCV's people detector calls a person (score above 0), in the
             video and simulated at the same heights in pixels, also with pictures shrunk

Cameras have 640 x 480 pixels over 50 degrees; a person of 1.7 m at 30 m is 39 pixels high.
"""

import argparse
import math
import os
from dataclasses import replace
from pathlib import Path

from benchmarks.pedestrians.false_tracks import false_row
from benchmarks.pedestrians.rates import rate_row
from benchmarks.pedestrians.recall import RANGES_M, RecallScore
from benchmarks.pedestrians.recognition import real_scores, recognition_row, simulated_scores
from benchmarks.pedestrians.scenes import SECONDS, PeopleDrive
from benchmarks.reporting.report import Row, RunReport
from contract.roads.load import load_map
from contract.roads.model import RoadMap
from simulator.sensors.cameras import light as lights
from simulator.sensors.cameras.light import Light
from simulator.sensors.cameras.mounts import CameraMount, four_cameras
from simulator.sensors.scene.changes import WorldChanges
from simulator.sensors.scene.static_scene import StaticScene
from vehicle_agent.config import Body, load_profile
from vehicle_agent.perception.camera.people_detector import HogPeopleDetector
from vehicle_agent.perception.laser_people.people import LaserPeople

_ROOT = Path(__file__).resolve().parents[2]
_SPEED_MPS = 1.5
_LIGHTS: dict[str, Light] = {
    "day": lights.DAY, "overcast": lights.OVERCAST, "night": lights.NIGHT, "rain": lights.RAIN,
    "low_sun": lights.LOW_SUN,
}  # fmt: skip


def main() -> None:
    report = RunReport()
    arguments = _arguments()
    os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
    body = load_profile(arguments.profile).body
    front = four_cameras(body)[0]
    rows: list[Row] = [rate_row(candidates, front, arguments.cycles) for candidates in (10, 40)]
    road_map = load_map(arguments.map)
    scene = StaticScene(road_map, 1, WorldChanges(seed=arguments.seed))
    recalls: list[Row] = []
    for name in arguments.lights:
        recalls += _recall_rows(road_map, scene, body, front, name, arguments)
    rows += recalls
    if arguments.minutes > 0.0:
        windy = StaticScene(road_map, 1, replace(WorldChanges(seed=arguments.seed), sway_m=0.2))
        rows.append(false_row(road_map, windy, body, front, arguments.minutes, arguments.seed))
        if arguments.laser_minutes > 0.0:
            rows.append(
                false_row(road_map, windy, body, front, arguments.laser_minutes, arguments.seed, False)
            )
    rows += _recognition_rows(road_map, scene, arguments)
    summary: Row = {
        "hz_10": rows[0]["hz"],
        "hz_40": rows[1]["hz"],
        "recall_20m": _recall_at(recalls, 20),
        "recall_30m": _recall_at(recalls, 30),
        "false_per_min": next((row["false_per_min"] for row in rows if row["part"] == "false"), None),
        # Of the longest drive.
        "moving_per_min": next((row["moving_per_min"] for row in rows[::-1] if row["part"] == "false"), None),
    }
    plain = {
        "map": str(arguments.map), "seed": arguments.seed, "drives": arguments.drives,
        "people": arguments.people,
        "minutes": arguments.minutes, "laser_minutes": arguments.laser_minutes,
        "lights": ",".join(arguments.lights), "cycles": arguments.cycles,
        "video": str(arguments.video) if arguments.video else "", "cores_used": 1,
    }  # fmt: skip
    report.write(arguments.json, "pedestrians", plain, rows, summary)


def _recall_rows(
    road_map: RoadMap,
    scene: StaticScene,
    body: Body,
    front: CameraMount,
    light: str,
    arguments: argparse.Namespace,
) -> list[Row]:
    score = RecallScore(LaserPeople(), HogPeopleDetector())
    for seed in range(arguments.seed, arguments.seed + arguments.drives):
        score.drive(
            PeopleDrive(
                road_map, scene, body, front, _LIGHTS[light], seed, arguments.people, _SPEED_MPS, SECONDS
            )
        )
    rows: list[Row] = []
    for range_m in RANGES_M:
        count, tracked, labelled = score.samples.recall(range_m)
        rows.append(
            {
                "part": "recall", "case": f"{light}, {range_m} m", "samples": count,
                "tracked_pct": 100.0 * tracked if count else None,
                "recall_pct": 100.0 * labelled if count else None,
                "false_labels": score.false_labels, "people": score.samples.people,
            }
        )  # fmt: skip
    return rows


def _recall_at(rows: list[Row], range_m: int) -> float | None:
    """Recall over the lights of day, weighted by samples."""
    found = [
        (float(row["samples"] or 0), float(row["recall_pct"] or 0.0))
        for row in rows
        if str(row["case"]) in (f"day, {range_m} m", f"overcast, {range_m} m")
    ]
    total = sum(count for count, _ in found)
    return sum(count * share for count, share in found) / total if total else None


def _recognition_rows(road_map: RoadMap, scene: StaticScene, arguments: argparse.Namespace) -> list[Row]:
    detector, rows = HogPeopleDetector(8, 8), []
    seeds = range(arguments.seed, arguments.seed + arguments.views)
    for shrink in (1.0, 0.5):
        if arguments.video is not None:
            rows.append(recognition_row("video", shrink, real_scores(arguments.video, shrink, detector)))
        for name in ("day", "overcast"):
            scores = simulated_scores(road_map, scene, _LIGHTS[name], shrink, detector, seeds)
            rows.append(recognition_row(f"simulated, {name}", shrink, scores))
    return [{key: None if _is_nan(value) else value for key, value in row.items()} for row in rows]


def _is_nan(value: object) -> bool:
    return isinstance(value, float) and math.isnan(value)


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="benchmarks.pedestrians", description=__doc__)
    parser.add_argument("--map", type=Path, default=_ROOT / "maps/shanghai-university/map.json")
    parser.add_argument("--profile", type=Path, default=_ROOT / "vehicle_agent/profiles/nus-cart.toml")
    parser.add_argument(
        "--seed", type=int, default=101, help="first seed; those below 100 were used for tuning"
    )
    parser.add_argument("--drives", type=int, default=4, help="drives of each light")
    parser.add_argument("--people", type=int, default=10, help="in each drive")
    parser.add_argument("--lights", nargs="+", choices=sorted(_LIGHTS), default=["day", "overcast"])
    parser.add_argument("--minutes", type=float, default=0.5, help="driven among trees; 0: none")
    parser.add_argument("--laser-minutes", type=float, default=5.0, help="more of them, by the laser alone")
    parser.add_argument("--views", type=int, default=10, help="pictures of simulated people for recognition")
    parser.add_argument("--cycles", type=int, default=100, help="of each rate")
    parser.add_argument("--video", type=Path, help="people before a fixed camera, such as vtest.avi")
    parser.add_argument("--json", type=Path, help="where to write the report")
    return parser.parse_args()


if __name__ == "__main__":
    main()
