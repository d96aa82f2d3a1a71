"""`omnimate serve`: the calibration service; `omnimate key`: who may call it."""

from __future__ import annotations

import errno
import gc
import logging
import socket
import sys
import time
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from omnimate.cli.config_file import ConfigFile
from omnimate.cli.console import out, say
from omnimate.cli.errors import CallError
from omnimate.cli.tables import new_table, show

if TYPE_CHECKING:
    from collections.abc import Callable

    import uvicorn

    from omnimate.service.components import Components
    from omnimate.service.settings import Settings
    from omnimate.service.store.database import Database as ServiceDatabase

DATABASE = "sqlite:///omnimate.db"
MAX_NAME = 100  # characters of a key's name, as the table has them
LIBRARIES = ("alembic", "fastapi", "prometheus_client", "sqlalchemy", "uvicorn")  # of the extra `service`
Database = Annotated[
    str,
    typer.Option(envvar="OMNIMATE_DATABASE", help="sqlite:///FILE or postgresql+psycopg://USER@HOST/NAME."),
]
keys = typer.Typer(help="API keys of the service: add, list, revoke.", no_args_is_help=True)


def serve(
    bus: Annotated[
        str | None,
        typer.Option(
            envvar="OMNIMATE_BUS",
            help="socketcan://can0, socketcand://host:port/can0, ...; else a simulated robot.",
        ),
    ] = None,
    vehicle: Annotated[
        Path | None,
        typer.Option(
            envvar="OMNIMATE_VEHICLE",
            help="vehicle.toml of the robot; else the reference robot.",
            exists=True,
            dir_okay=False,
        ),
    ] = None,
    database: Database = DATABASE,
    host: Annotated[
        str,
        typer.Option(envvar="OMNIMATE_HOST", help="Address to listen at; others than loopback need keys."),
    ] = "127.0.0.1",
    port: Annotated[
        int,
        typer.Option(
            envvar="OMNIMATE_PORT", help="Port to listen at; 0 takes a free port.", min=0, max=65535
        ),
    ] = 8080,
    pace: Annotated[
        float,
        typer.Option(
            envvar="OMNIMATE_PACE",
            help="Pace of a driving simulated robot, in multiples of real time.",
            min=0.1,
            max=1000.0,
        ),
    ] = 40.0,
    rate: Annotated[
        float,
        typer.Option(envvar="OMNIMATE_RATE", help="Calls a second that one caller may make.", min=1.0),
    ] = 1000.0,
    fleets: Annotated[
        str, typer.Option(envvar="OMNIMATE_FLEETS", help="Folder or URL for all recordings and fleets.")
    ] = "fleets",
    jobs: Annotated[
        int,
        typer.Option(
            envvar="OMNIMATE_JOBS", help="Processes for a fleet's batch; more than 1 need Dask.", min=1
        ),
    ] = 1,
    scheduler: Annotated[
        str | None,
        typer.Option(
            envvar="OMNIMATE_SCHEDULER",
            help="Address of a Dask scheduler for batches: tcp://10.0.0.1:8786.",
        ),
    ] = None,
    mqtt: Annotated[
        str | None,
        typer.Option(envvar="OMNIMATE_MQTT", help="Publish the robot by VDA 5050: mqtt://HOST[:PORT]."),
    ] = None,
    factsheet: Annotated[
        Path | None,
        typer.Option(
            envvar="OMNIMATE_FACTSHEET",
            help="The robot's VDA 5050 factsheet (JSON), which --mqtt needs.",
            exists=True,
            dir_okay=False,
        ),
    ] = None,
    flight_recorder: Annotated[
        Path | None,
        typer.Option(
            envvar="OMNIMATE_FLIGHT_RECORDER",
            help="Folder for the last minute before each fault of the robot, as a recording.",
        ),
    ] = None,
    log_format: Annotated[
        Literal["text", "json"],
        typer.Option(
            envvar="OMNIMATE_LOG_FORMAT",
            help="json writes one object a line to stderr: every request, warnings, errors.",
        ),
    ] = "text",
    config: ConfigFile = None,  # noqa: ARG001  # its callback has read it
) -> None:
    """Serve calibration, recordings, diagnoses and fleets over REST, with a web page."""
    _require_service()
    from omnimate.service.request_log import log_as_json
    from omnimate.service.settings import Settings

    if log_format == "json":
        log_as_json()
    settings = Settings(
        bus,
        vehicle,
        database,
        fleets=fleets,
        jobs=jobs,
        scheduler=scheduler,
        host=host,
        port=port,
        pace=pace,
        rate=rate,
        mqtt=mqtt,
        factsheet=factsheet,
        flight_recorder=flight_recorder,
    )
    if (jobs > 1 or scheduler is not None) and find_spec("distributed") is None:
        asked = f"--jobs {jobs}" if scheduler is None else "--scheduler"
        raise CallError(f"{asked} needs Dask: pip install 'omnimate[cluster]', or leave {asked} out")
    _listen(settings, as_json=log_format == "json")


def _require_service() -> None:
    """Check that the libraries of the extra `service` are installed."""
    missing = [name for name in LIBRARIES if find_spec(name) is None]
    if missing:
        raise CallError(f"the service needs {', '.join(missing)}: pip install 'omnimate[service]'")


def _opened(database: str, *, existing: bool = False) -> ServiceDatabase:
    """Return the service's database; `existing` refuses a file that is not there, which else is made."""
    _require_service()
    from omnimate.service.store.database import Database

    return Database(database, existing=existing)


def _listen(settings: Settings, *, as_json: bool) -> None:
    from omnimate.service.processes import process_context, return_freed_memory

    process_context()  # loads the libraries of other processes while this one loads its own
    import uvicorn

    from omnimate.service.access import keys as keys_of
    from omnimate.service.app import create_app
    from omnimate.service.components import Components
    from omnimate.service.robot.robot_server import GC_THRESHOLDS, SWITCH_INTERVAL

    components = Components(settings)
    if not settings.is_loopback:
        with components.database.reading() as db:
            if not any(key.revoked is None for key in keys_of(db)):
                raise CallError(
                    f"{settings.host} can be reached from outside: make a key first (omnimate key add NAME "
                    f"--role operate --database {settings.database}), or listen on 127.0.0.1"
                )
    sockets = _sockets(settings.host, settings.port)  # before the robot is touched
    config = uvicorn.Config(
        create_app(components),
        settings.host,
        settings.port,
        log_config=None if as_json else uvicorn.config.LOGGING_CONFIG,
        log_level="warning",
        timeout_graceful_shutdown=3,
        timeout_keep_alive=60,
    )
    sys.setswitchinterval(SWITCH_INTERVAL)
    gc.set_threshold(*GC_THRESHOLDS)
    return_freed_memory()
    announce = logging.getLogger(__name__).info if as_json else say
    _make_server(config, announce, components).run(sockets)


def _sockets(host: str, port: int) -> list[socket.socket]:
    """Return sockets that listen at all addresses of a host; CallError where one of them cannot."""
    try:
        addresses = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE)
        return [socket.create_server(address, family=family) for family, *_, address in addresses]
    except OSError as error:
        if error.errno == errno.EADDRINUSE:
            raise CallError(
                f"port {port} of {host} is in use, perhaps by another omnimate serve: end that program, or "
                "choose another --port (0 takes a free one)"
            ) from error
        raise CallError(
            f"cannot listen at {host}, port {port}: {error.strerror}; expected an address of this machine in "
            "--host, and in --port a port that this user may open"
        ) from error


def _make_server(
    config: uvicorn.Config, announce: Callable[[str], None], components: Components
) -> uvicorn.Server:
    """Return a server that announces its addresses once it listens, and stops the robot before it ends."""
    import uvicorn

    class Server(uvicorn.Server):
        async def startup(self, sockets: list[socket.socket] | None = None) -> None:
            await super().startup(sockets)
            for server in self.servers:
                for bound in server.sockets:
                    host, port = bound.getsockname()[:2]
                    announce(f"http://[{host}]:{port}" if ":" in host else f"http://{host}:{port}")

        async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
            components.stop()
            await super().shutdown(sockets)

    return Server(config)


@keys.command()
def add(
    name: Annotated[str, typer.Argument(help="Name of the person or program that uses the key.")],
    role: Annotated[
        Literal["read", "operate"], typer.Option(help="operate may move the robot and change things.")
    ] = "read",
    database: Database = DATABASE,
) -> None:
    """Make a key, and print it; it cannot be shown again."""
    if not 0 < len(name.strip()) <= MAX_NAME:
        raise CallError(f"NAME: {name!r}; expected 1 to {MAX_NAME} characters, who or what uses the key")
    store = _opened(database)
    from omnimate.service.access import add_key

    with store.writing() as db:
        key = add_key(db, name, role)
    say(key)


@keys.command(name="list")
def list_(database: Database = DATABASE) -> None:
    """List the keys; the secret part of a key is not kept."""
    store = _opened(database, existing=True)
    from omnimate.service.access import keys as keys_of

    with store.reading() as db:
        rows = [(key.id, key.name, key.role, _day(key.created), _day(key.revoked)) for key in keys_of(db)]
    show(new_table("", ("id", "name", "role", "made", "revoked"), rows=rows))


@keys.command()
def revoke(
    identity: Annotated[
        str, typer.Argument(metavar="ID", help="Identity of the key, as `key list` shows it.")
    ],
    database: Database = DATABASE,
) -> None:
    """Revoke a key."""
    store = _opened(database, existing=True)
    from omnimate.service.access import revoke_key
    from omnimate.service.errors import NotFoundError

    try:
        with store.writing() as db:
            name = revoke_key(db, identity).name
    except NotFoundError as error:
        raise CallError(f"there is no key {identity!r}; omnimate key list shows which there are") from error
    out.print(f"the key of {name} is void")


def _day(seconds: float | None) -> str:
    return "" if seconds is None else time.strftime("%Y-%m-%d %H:%M", time.localtime(seconds))
