"""`omnimate serve`: the calibration service; `omnimate key`: who may call it."""

from __future__ import annotations

import gc
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.table import Table

from cli.choices import KeyRole
from cli.console import out
from vehicle.errors import OmnimateError

if TYPE_CHECKING:
    import socket

    import uvicorn

    from service.settings import Settings

DATABASE = "sqlite:///omnimate.db"
COLLECTED = 20_000, 20, 20  # objects between two looks for cycles, which stop everything
SWITCH = 0.0002  # [s] for which one thread may keep the others waiting: the robot, calls, the stream
Database = Annotated[
    str,
    typer.Option(envvar="OMNIMATE_DATABASE", help="sqlite:///FILE or postgresql+psycopg://USER@HOST/NAME."),
]
keys = typer.Typer(help="API keys of the service: add, list, revoke.", no_args_is_help=True)


class OpenDoorError(OmnimateError):
    """Listening to the network without a single key."""


def serve(
    bus: Annotated[
        str | None,
        typer.Option(help="socketcan://can0, socketcand://host:port/can0, ...; else a simulated robot."),
    ] = None,
    vehicle: Annotated[Path | None, typer.Option(help="vehicle.toml; else the reference robot.")] = None,
    database: Database = DATABASE,
    host: Annotated[str, typer.Option(help="To listen at; others than loopback need keys.")] = "127.0.0.1",
    port: Annotated[int, typer.Option(help="0 takes a free one.", min=0, max=65535)] = 8080,
    pace: Annotated[
        float, typer.Option(help="Of a simulated robot while it drives, in real times.", min=0.1, max=1000.0)
    ] = 40.0,
    rate: Annotated[float, typer.Option(help="Calls a second that one caller may make.", min=1.0)] = 1000.0,
) -> None:
    """Serve calibration, recordings and diagnoses over REST, and a page for people, until Ctrl-C."""
    from service.settings import Settings

    _listen(Settings(bus, vehicle, database, host, port, pace, rate=rate))


def _listen(settings: Settings) -> None:
    import uvicorn

    from service.access import keys as keys_of
    from service.app import create_app
    from service.parts import make_parts

    parts = make_parts(settings)
    if not settings.is_loopback:
        with parts.database.reading() as db:
            if not any(key.revoked is None for key in keys_of(db)):
                raise OpenDoorError(
                    f"{settings.host} can be reached from outside: make a key first (omnimate key add NAME "
                    f"--role operate --database {settings.database}), or listen on 127.0.0.1"
                )
    config = uvicorn.Config(
        create_app(parts),
        settings.host,
        settings.port,
        log_level="warning",
        timeout_graceful_shutdown=3,
        timeout_keep_alive=60,
    )
    sys.setswitchinterval(SWITCH)
    gc.set_threshold(*COLLECTED)
    announced(config).run()


def announced(config: uvicorn.Config) -> uvicorn.Server:
    """Return a server that says where it listens once it does."""
    import uvicorn

    class Server(uvicorn.Server):
        async def startup(self, sockets: list[socket.socket] | None = None) -> None:
            await super().startup(sockets)
            for server in self.servers:
                for bound in server.sockets:
                    host, port = bound.getsockname()[:2]
                    out.print(f"http://{host}:{port}", soft_wrap=True)

    return Server(config)


@keys.command()
def add(
    name: Annotated[str, typer.Argument(help="Whose key it is.")],
    role: Annotated[
        KeyRole, typer.Option(help="operate may move the robot and change things.")
    ] = KeyRole.read,
    database: Database = DATABASE,
) -> None:
    """Make a key; it is shown once."""
    from service.access import add_key
    from service.store.database import Database as Opened

    with Opened(database).writing() as db:
        key = add_key(db, name, role.value)
    out.print(key, markup=False, soft_wrap=True)


@keys.command(name="list")
def list_(database: Database = DATABASE) -> None:
    """List keys; what is secret about them is not kept."""
    from service.access import keys as keys_of
    from service.store.database import Database as Opened

    table = Table()
    for heading in ("id", "name", "role", "made", "revoked"):
        table.add_column(heading)
    with Opened(database).reading() as db:
        for key in keys_of(db):
            table.add_row(key.id, key.name, key.role, _day(key.created), _day(key.revoked))
    out.print(table)


@keys.command()
def revoke(
    identity: Annotated[str, typer.Argument(metavar="ID", help="Of the key, as `key list` shows it.")],
    database: Database = DATABASE,
) -> None:
    """Make a key void."""
    from service.access import revoke_key
    from service.store.database import Database as Opened

    with Opened(database).writing() as db:
        name = revoke_key(db, identity).name
    out.print(f"the key of {name} is void", markup=False)


def _day(seconds: float | None) -> str:
    return "" if seconds is None else time.strftime("%Y-%m-%d %H:%M", time.localtime(seconds))
