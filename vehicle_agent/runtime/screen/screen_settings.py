"""screen.toml: where the onboard screen is served, and to whom."""

import ipaddress
from pathlib import Path

import msgspec

Network = ipaddress.IPv4Network | ipaddress.IPv6Network
WEB_PAGES = Path(__file__).parents[3] / "web" / "dist"


class ScreenError(Exception):
    """The onboard screen cannot be served; the message says what to do."""


class ScreenSettings(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """listen    HOST:PORT of this computer on the vehicle's own network
    networks  whose tablets may use the screen, besides this computer
    pages     folder of the built web pages
    """

    listen: str = "127.0.0.1:47700"
    networks: tuple[str, ...] = ()
    pages: str = str(WEB_PAGES)

    def address(self) -> tuple[str, int]:
        """(host, port). Raises ScreenError."""
        host, _, port = self.listen.rpartition(":")
        if not host or not port.isdecimal() or int(port) > 65_535:
            raise ScreenError(f"screen.toml: listen is {self.listen!r}; give HOST:PORT of this computer")
        return host.strip("[]"), int(port)

    def allowed(self) -> tuple[Network, ...]:
        """The networks with this computer. Raises ScreenError, also for one that is not private."""
        found: list[Network] = [ipaddress.ip_network("127.0.0.0/8"), ipaddress.ip_network("::1/128")]
        for text in self.networks:
            try:
                network = ipaddress.ip_network(text)
            except ValueError as error:
                raise ScreenError(f"screen.toml: {error}") from error
            if not network.is_private:
                raise ScreenError(f"screen.toml: {text} is not private; name the vehicle's own network")
            found.append(network)
        return tuple(found)


def load_screen_settings(path: Path) -> ScreenSettings | None:
    """The settings; None without the file: the vehicle serves no screen. Raises ScreenError."""
    try:
        settings = msgspec.toml.decode(path.read_bytes(), type=ScreenSettings)
    except FileNotFoundError:
        return None
    except msgspec.DecodeError as error:
        raise ScreenError(f"{path}: {error}") from error
    settings.address()
    settings.allowed()
    if not (Path(settings.pages) / "onboard.html").is_file():
        raise ScreenError(f"no onboard.html in {settings.pages}: run `make web`, or set `pages`")
    return settings
