"""Maps from laser logs against known relations: `python -m benchmarks.slam2d LOG --relations FILE --json F`.

LOG is a CARMEN log, FILE has relations in the published benchmark's format (Kuemmerle et al. 2009): mean_m
and mean_deg are the mean absolute errors of the relative poses of the laser. Without --relations only the
residuals and the times are measured: how far passes of one place agree is no measure of truth. --out DIR
writes the map, the trajectory, the report and a picture for others to score again.
"""

import argparse
import time
from pathlib import Path

import numpy as np

from benchmarks.reporting.report import Row, RunReport
from workshop.carmen.laser_logs import LaserLog, read_laser_log
from workshop.laser_mapping.map_folder import write_map_folder
from workshop.laser_mapping.mapping import LaserMap, MappingParams, NoProgress, map_log
from workshop.laser_mapping.relations import Relations, read_relations, relation_errors
from workshop.laser_mapping.warm import warm_kernels


def main() -> None:
    report = RunReport()
    arguments = _arguments()
    log = read_laser_log(arguments.log)
    relations = None if arguments.relations is None else read_relations(arguments.relations)
    warm_kernels()
    wall_s, cpu_s = time.perf_counter(), time.process_time()
    laser_map = map_log(log, MappingParams(), NoProgress())
    wall_s, cpu_s = time.perf_counter() - wall_s, time.process_time() - cpu_s
    if arguments.out is not None:
        write_map_folder(arguments.out, laser_map, log, arguments.log.name)
    row = {"log": arguments.log.name, **measured(log, laser_map, relations), "cpu_s": cpu_s, "wall_s": wall_s}
    summary = {key: row[key] for key in ("mean_m", "mean_deg", "relations", "cpu_s", "wall_s")}
    given = {
        "log": str(arguments.log),
        "relations": None if arguments.relations is None else str(arguments.relations),
    }
    report.write(arguments.json, "slam2d", given, [row], summary)


def measured(log: LaserLog, laser_map: LaserMap, relations: Relations | None) -> Row:
    """Errors against the relations, None without any, beside the map's own residuals."""
    numbers = laser_map.residuals
    row: dict[str, float | int | str | None] = {
        "scans": numbers.scans,
        "way_m": numbers.way_m,
        "loops": numbers.loops_closed,
        "pass_median_m": numbers.pass_median_m,
        "pass_p95_m": numbers.pass_p95_m,
        "relations": 0,
        "relations_missing": 0,
    }
    names = ("mean_m", "std_m", "max_m", "mean_deg", "std_deg", "max_deg")
    if relations is None:
        return row | dict.fromkeys(names)
    errors = relation_errors(relations, log.stamps_s, laser_map.poses)
    row |= {"relations": len(errors.translations_m), "relations_missing": errors.missing}
    if not len(errors.translations_m):
        return row | dict.fromkeys(names)
    values = [
        float(measure(values))
        for values in (errors.translations_m, np.degrees(errors.rotations_rad))
        for measure in (np.mean, np.std, np.max)
    ]
    return row | dict(zip(names, values, strict=True))


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="benchmarks.slam2d", description=__doc__)
    parser.add_argument("log", type=Path, help="CARMEN log, plain, .gz or .bz2")
    parser.add_argument("--relations", type=Path, help="known relative poses")
    parser.add_argument("--out", type=Path, help="folder for map, trajectory, report and picture")
    parser.add_argument("--json", type=Path, help="where to write the report")
    return parser.parse_args()


if __name__ == "__main__":
    main()
