"""docker-compose.yml and what it mounts: valid, complete and hardened."""

import json
import re
import shutil
import subprocess
from pathlib import Path

import pytest
from prometheus_client.parser import text_string_to_metric_families

from server.settings import settings_from
from tests.deploy.compose.compose_file import ROOT, compose_file
from tests.server.api.server_under_test import ServerUnderTest

DOCUMENT = compose_file()
SERVICES = DOCUMENT["services"]
FOLDER = ROOT / "deploy" / "compose"
DASHBOARD = FOLDER / "grafana" / "dashboards" / "campusloop.json"


def passes(*command: str | Path) -> str:
    """ "" if the program accepts the file, else what it says; skipped without the program."""
    if shutil.which(command[0]) is None:
        pytest.skip(f"{command[0]} is not installed: scripts/services")
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=60, check=False)
    return "" if done.returncode == 0 else done.stdout + done.stderr


@pytest.mark.real
@pytest.mark.parametrize(
    "command",
    [
        ("docker-compose", "-f", "docker-compose.yml", "config", "-q"),
        ("caddy", "validate", "--config", FOLDER / "Caddyfile", "--adapter", "caddyfile"),
        ("promtool", "check", "config", "--syntax-only", FOLDER / "prometheus.yml"),
        ("promtool", "check", "rules", FOLDER / "alerts.yml"),
    ],
)
def test_the_programs_accept_their_files(command: tuple[str | Path, ...]) -> None:
    assert passes(*command) == ""


def test_what_was_asked_for_is_there() -> None:
    assert set(SERVICES) >= {"postgres", "nats", "proxy", "shuttles", "prometheus", "grafana"}
    servers = [service for service in SERVICES.values() if service.get("command", [""])[0] == "serve"]
    assert len(servers) == 2


def test_every_service_is_checked_for_health_or_waits_for_one_that_is() -> None:
    for name, service in SERVICES.items():
        assert "healthcheck" in service or name == "shuttles", name
        for needed, how in service.get("depends_on", {}).items():
            assert how == {"condition": "service_healthy"}
            assert "healthcheck" in SERVICES[needed], f"{name} waits for {needed}"


def test_every_service_but_the_database_has_a_read_only_root_and_no_privileges() -> None:
    for name, service in SERVICES.items():
        if name == "postgres":
            continue
        assert service["read_only"] is True, name
        assert service["cap_drop"] == ["ALL"], name
        assert service["security_opt"] == ["no-new-privileges:true"], name


def test_only_the_proxy_is_reached_from_other_machines() -> None:
    for name, service in SERVICES.items():
        for port in service.get("ports", []):
            assert name == "proxy" or port.startswith("127.0.0.1:"), (name, port)


def test_no_secret_is_in_the_file_and_each_is_made_by_the_script(tmp_path: Path) -> None:
    shutil.copy(FOLDER / "make-secrets", tmp_path)
    first = subprocess.run(
        [tmp_path / "make-secrets"], capture_output=True, text=True, check=True, timeout=30
    )
    made = {path.name: path.read_text() for path in (tmp_path / "secrets").iterdir()}
    assert set(made) == set(DOCUMENT["secrets"])
    assert all(len(value) >= 16 for value in made.values())
    assert (tmp_path / "secrets").stat().st_mode & 0o077 == 0
    again = subprocess.run(
        [tmp_path / "make-secrets"], capture_output=True, text=True, check=True, timeout=30
    )
    assert again.stdout == first.stdout, "secrets that are there stay"
    assert not any(value in (ROOT / "docker-compose.yml").read_text() for value in made.values())


def test_the_servers_settings_can_be_used(tmp_path: Path) -> None:
    for name in ("server-1", "server-2"):
        given = {key: str(value) for key, value in SERVICES[name]["environment"].items()}
        for key, value in given.items():
            if value.startswith("/run/secrets/"):
                path = tmp_path / Path(value).name
                path.write_text("secret")
                given[key] = str(path)
        settings = settings_from(given)
        assert settings.server_name == name
        assert settings.metrics_token == "secret"


def test_what_is_mounted_and_copied_exists() -> None:
    for service in SERVICES.values():
        for volume in service.get("volumes", []):
            source = volume.split(":")[0]
            if source.startswith("."):
                assert (ROOT / source).exists(), source
            else:
                assert source in DOCUMENT["volumes"], source
    text = (ROOT / "Dockerfile").read_text()
    copied = re.findall(r"^COPY (?!--from)(.+) \S+$", text, re.MULTILINE)
    assert copied
    for source in " ".join(copied).split():
        assert (ROOT / source).exists(), source


def test_the_image_runs_as_no_root_in_a_folder_of_its_own() -> None:
    last = (ROOT / "Dockerfile").read_text().rsplit("FROM ", 1)[1]
    assert re.search(r"^USER \d+$", last, re.MULTILINE)
    assert sum(line.startswith(("RUN", "COPY")) for line in last.splitlines()) <= 4, "few layers"


def test_the_dashboard_and_the_alerts_ask_only_for_what_the_server_measures(tmp_path: Path) -> None:
    dashboard = json.loads(DASHBOARD.read_text())
    asked = [target["expr"] for panel in dashboard["panels"] for target in panel["targets"]]
    asked.append((FOLDER / "alerts.yml").read_text().replace("name: campusloop", ""))
    server = ServerUnderTest(tmp_path, metrics_token="measure")
    server.get("/stops")
    text = server.get("/metrics", headers={"Authorization": "Bearer measure"}).text
    server.close()
    measured = {sample.name for family in text_string_to_metric_families(text) for sample in family.samples}
    names = {name for expression in asked for name in re.findall(r"campusloop_\w+", expression)}
    assert names
    assert names <= measured


def test_panels_do_not_overlap() -> None:
    taken: set[tuple[int, int]] = set()
    for panel in json.loads(DASHBOARD.read_text())["panels"]:
        at = panel["gridPos"]
        cells = {(at["x"] + i, at["y"] + j) for i in range(at["w"]) for j in range(at["h"])}
        assert not cells & taken, panel["title"]
        assert max(x for x, _ in cells) < 24
        taken |= cells
