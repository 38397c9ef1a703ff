"""`campusloop workshop`: offline work on recorded sensor logs."""

import typer

from campusloop.commands.workshop.build_map import build_map
from campusloop.commands.workshop.calibrate import calibrate_lidars
from campusloop.commands.workshop.calibrate_camera import calibrate_camera
from campusloop.commands.workshop.propose import propose_map
from campusloop.commands.workshop.site_maps import survey_laser
from campusloop.commands.workshop.survey import survey
from campusloop.commands.workshop.train_detector import train_detector

app = typer.Typer(no_args_is_help=True)
app.command("calibrate")(calibrate_lidars)
app.command("calibrate-camera")(calibrate_camera)
app.command("survey")(survey)
app.command("survey-laser")(survey_laser)
app.command("propose")(propose_map)
app.command("train-detector")(train_detector)
app.command("map")(build_map)
