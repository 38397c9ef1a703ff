"""Settings, read once: `CAMPUSLOOP_*` in the environment over defaults that suit one machine."""

from collections.abc import Mapping
from pathlib import Path
from urllib.parse import urlsplit

from pydantic import BaseModel, ConfigDict, Field, ValidationError, field_validator

from server.addresses import ForwardedHeader, Network, host_of, hosts_of, networks_of

PREFIX = "CAMPUSLOOP_"
FILE_SUFFIX = "_file"
MIB = 1024 * 1024


class SettingsError(Exception):
    """A setting that cannot be used; the text names it and what it may be."""


class Settings(BaseModel):
    """Everything that differs between two installations. Frozen: settings do not change at run time."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    host: str = Field("127.0.0.1", description="Address to listen on; anything but loopback needs TLS.")
    port: int = Field(8080, ge=0, le=65535, description="TCP port; 0 takes any free one.")
    var_dir: Path = Field(Path("var"), description="Where the database, run segments and certificates live.")
    database_url: str = Field("", description="SQLAlchemy URL; empty: an SQLite file under var_dir.")
    ticket_key_file: Path | None = Field(
        None,
        description="Keys of passengers' links and codes, the same for all replicas; empty: in var_dir.",
    )
    push_key_file: Path | None = Field(
        None,
        description="Key that push services know the server by, the same for all replicas; empty: in "
        "var_dir.",
    )
    push_contact: str = Field(
        "",
        max_length=200,
        pattern=r"^((mailto:|https://)[\x21-\x7e]+)?$",
        description="mailto: or https: of those who run the server, for push services; Apple's wants one.",
    )
    bus_url: str = Field("", description="nats://host:port; empty: in-process, for one server process.")
    map_path: Path | None = Field(
        None, description="Campus map to make active at start; empty: keep the last."
    )
    campus_id: str = Field("", max_length=64, description="Empty: the map's.")
    web_dist: Path = Field(Path("web/dist"), description="The built web pages.")
    public_url: str = Field(
        "", description="How the outside reaches us, for links; empty: from host and port."
    )
    tls_cert: Path | None = Field(None, description="PEM certificate chain.")
    tls_key: Path | None = Field(None, description="PEM private key of tls_cert.")
    operator_name: str = Field("operator", min_length=1, max_length=64, description="First operator's name.")
    operator_password: str = Field("", description="First operator's password; empty: none is created.")
    service_opens: str = Field("00:00", pattern=r"^\d\d:\d\d$", description="Campus local time.")
    service_closes: str = Field("24:00", pattern=r"^\d\d:\d\d$", description="Campus local time.")
    session_hours: float = Field(12.0, gt=0, le=168, description="How long an operator stays signed in.")
    segments_url: str = Field(
        "",
        description="Where run segments are kept: s3://, gs:// or az://BUCKET/PREFIX; empty: under var_dir.",
    )
    rider_days: float = Field(
        30.0, gt=0, le=3650, description="How long after its end a ride names its rider; then it is erased."
    )
    video_days: float = Field(
        14.0, gt=0, le=3650, description="How long video that vehicles have sent is kept."
    )
    scan_days: float = Field(
        90.0, gt=0, le=3650, description="How long after their request scans are kept, and decided proposals."
    )
    audit_address_days: float = Field(
        90.0, gt=0, le=3650, description="How long the audit log keeps addresses; the entries stay."
    )
    second_factor_required: bool = Field(
        False, description="To set a vehicle in motion or give access, an operator must have a second factor."
    )
    second_factor_hours: float = Field(
        8.0, gt=0, le=168, description="How long a session may do so after its second factor was checked."
    )
    second_factor_tries_per_minute: int = Field(5, ge=1, description="Codes per operator; then 429.")
    webhook_failure_days: float = Field(
        5.0, gt=0, le=365, description="A webhook that has failed for so long is disabled."
    )
    webhook_allowed_networks: str = Field(
        "",
        description="Private networks, with commas, that webhooks may lead into, also by http; empty: none.",
    )
    segment_bytes_max: int = Field(256 * MIB, ge=MIB, description="Largest run segment taken in.")
    login_tries_per_minute: int = Field(
        6, ge=1, description="Per client network, and per browser that has signed in before; then 429."
    )
    account_login_tries_per_minute: int = Field(
        20, ge=1, description="Per operator, from all browsers that have not signed in before; then 429."
    )
    lookups_per_minute: int = Field(20, ge=1, description="Ride codes tried per client network, then 429.")
    bookings_per_minute: int = Field(
        30, ge=1, description="Bookings per client network, or per developer token; then 429."
    )
    offers_per_minute: int = Field(
        60, ge=1, description="Looks for a free shuttle per client network, by phones that wait; then 429."
    )
    commands_per_minute: int = Field(
        120, ge=1, description="Commands per operator, developer token or ride; then 429."
    )
    trusted_proxies: str = Field(
        "", description="Networks of proxies, with commas, whose word on the client's address is believed."
    )
    forwarded_header: ForwardedHeader = Field(
        "x-forwarded-for", description="The header in which they give it: the other one is ignored."
    )
    allowed_hosts: str = Field(
        "", description="Host names, with commas, that requests may be for; empty: any. *.example.org works."
    )
    connections_per_address_max: int = Field(
        2_000, ge=1, description="Connections of one client network at a time; loopback has no limit."
    )
    connections_max: int = Field(20_000, ge=1, description="Connections and requests at a time, then 503.")
    hello_timeout_s: float = Field(10.0, gt=0, description="How long a vehicle may take for its hello.")
    live_interval_s: float = Field(
        0.2, gt=0, description="Least time between two scene deltas to one viewer."
    )
    disk_free_bytes_min: int = Field(
        256 * MIB, ge=0, description="With less room under var_dir the server says that it is not ready."
    )
    server_name: str = Field(
        "server", min_length=1, max_length=64, description="Of this replica, in incidents and logs."
    )
    metrics_token: str = Field(
        "",
        max_length=256,
        description="Bearer token with which Prometheus may read /metrics; empty: a developer token only.",
    )
    with_loops: bool = Field(True, description="Run the dispatcher and the other loops here.")

    @field_validator("trusted_proxies", "webhook_allowed_networks")
    @classmethod
    def _are_networks(cls, value: str) -> str:
        networks_of(value)
        return value

    @field_validator("allowed_hosts")
    @classmethod
    def _are_hosts(cls, value: str) -> str:
        hosts_of(value)
        return value

    def proxies(self) -> tuple[Network, ...]:
        return networks_of(self.trusted_proxies)

    def webhook_networks(self) -> tuple[Network, ...]:
        return networks_of(self.webhook_allowed_networks)

    def hosts(self) -> tuple[str, ...]:
        """The names that requests may be for, that of the public address among them; empty: any."""
        named = hosts_of(self.allowed_hosts)
        return (*named, host_of(urlsplit(self.origin()).netloc)) if named else ()

    def is_loopback(self) -> bool:
        return is_loopback(self.host)

    def has_tls(self) -> bool:
        return self.tls_cert is not None and self.tls_key is not None

    def database(self) -> str:
        return self.database_url or f"sqlite:///{self.var_dir / 'campusloop.db'}"

    def ticket_keys(self) -> Path:
        return self.ticket_key_file or self.var_dir / "ticket.key"

    def push_key(self) -> Path:
        return self.push_key_file or self.var_dir / "push.key"

    def origin(self) -> str:
        """The address to print and to build links from."""
        if self.public_url:
            return self.public_url.rstrip("/")
        host = f"[{self.host}]" if ":" in self.host else self.host
        return f"{'https' if self.has_tls() else 'http'}://{host}:{self.port}"


def is_loopback(host: str) -> bool:
    return host in {"localhost", "::1"} or host.startswith("127.")


def settings_from(environment: Mapping[str, str], **overrides: object) -> Settings:
    """Settings from CAMPUSLOOP_* variables; overrides (command-line options, None ignored) win.

    CAMPUSLOOP_NAME_FILE is the file that holds the setting NAME, for secrets. Variables that are no settings
    are left alone. Raises SettingsError naming every one that cannot be used.
    """
    given: dict[str, object] = {}
    for variable, value in sorted(environment.items()):
        if not variable.startswith(PREFIX):
            continue
        name = variable.removeprefix(PREFIX).lower()
        if name in Settings.model_fields:
            given[name] = value
        elif is_file_variable(variable):
            if f"{PREFIX}{name.removesuffix(FILE_SUFFIX).upper()}" in environment:
                raise SettingsError(
                    f"{variable} and the setting itself are both given; leave one of them out"
                )
            given[name.removesuffix(FILE_SUFFIX)] = _content(variable, Path(value))
    given |= {name: value for name, value in overrides.items() if value is not None}
    try:
        settings = Settings.model_validate(given)
    except ValidationError as error:
        raise SettingsError(_explain(error)) from error
    if (settings.tls_cert is None) != (settings.tls_key is None):
        raise SettingsError("tls_cert and tls_key go together: give both or neither")
    return settings


def is_file_variable(variable: str) -> bool:
    """The variable names the file of a setting that is a text."""
    name = variable.removeprefix(PREFIX).lower()
    field = Settings.model_fields.get(name.removesuffix(FILE_SUFFIX))
    return name.endswith(FILE_SUFFIX) and field is not None and field.annotation is str


def _content(variable: str, path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8").rstrip("\r\n")
    except (OSError, UnicodeDecodeError) as error:
        raise SettingsError(f"{variable}: {path} cannot be read ({error})") from error


def _explain(error: ValidationError) -> str:
    lines = [f"{PREFIX}{'.'.join(map(str, item['loc'])).upper()}: {item['msg']}" for item in error.errors()]
    return "settings that cannot be used:\n  " + "\n  ".join(lines)
