"""The thread that publishes the robot by MQTT, and answers a fleet manager's requests."""

from __future__ import annotations

import json
import logging
import threading
import time
from typing import TYPE_CHECKING, Any
from urllib.parse import urlsplit

from omnimate.service.errors import ServiceError
from omnimate.service.threads import RepeatingThread
from omnimate.service.vda5050.messages import Sender, action_state, state_of, with_actions

if TYPE_CHECKING:
    from collections.abc import Callable

    from paho.mqtt.client import Client, MQTTMessage, MQTTMessageInfo

    from omnimate.service.robot.robot_process import RobotProcess
    from omnimate.service.vda5050.factsheet import Factsheet
    from omnimate.vehicle.parameters import VehicleParameters

MAX_STATE_PERIOD = 30.0  # [s] after which the state is sent even if nothing has changed: the standard's limit
KEPT_ACTIONS = 20  # states of the last instant actions that a state message lists
PORT = 1883
_log = logging.getLogger(__name__)


class BrokerError(ServiceError):
    """A broker's URL, without its password, that cannot be used."""

    def __init__(self, url: str, problem: str) -> None:
        super().__init__(f"{url}: {problem}; expected mqtt://[user:password@]host[:port]")
        self.url = url


class Publisher(RepeatingThread):
    """A robot's connection to a broker, which is made again whenever it is lost."""

    def __init__(
        self, url: str, sheet: Factsheet, robot: RobotProcess, vehicle: Callable[[], VehicleParameters]
    ) -> None:
        super().__init__("vda5050")
        self._sheet, self._robot, self._vehicle = sheet, robot, vehicle
        self._sender = Sender(sheet.manufacturer, sheet.serial)
        self._client, self._host, self._port = _client(url)
        self._lock = threading.Lock()
        self._actions: list[dict[str, Any]] = []
        self._sent_state: dict[str, Any] = {}
        self._sent_wheels: dict[str, Any] = {}
        self._sent_at = 0.0

    def start(self) -> None:
        """Connect, and start the thread."""
        client = self._client
        client.on_connect = lambda *_: self._go_online()
        client.on_message = lambda _client, _data, message: self._carry_out(message)
        broken = self._sender.message("connection", {"connectionState": "CONNECTIONBROKEN"}, time.time())
        client.will_set(self._sender.topic("connection"), json.dumps(broken), qos=1, retain=True)
        client.connect_async(self._host, self._port)
        client.loop_start()
        super().start()

    def close(self) -> None:
        """Publish that the robot goes offline, and end the threads."""
        super().close()
        if self._client.is_connected():
            self._publish("connection", {"connectionState": "OFFLINE"}).wait_for_publish(1.0)
        self._client.disconnect()
        self._client.loop_stop()

    def work(self) -> bool:
        """Publish the factsheet and the state where they have changed."""
        if self._client.is_connected():
            self._send_factsheet()
            self._send_state()
        return False

    def _go_online(self) -> None:
        """Publish ONLINE, subscribe to instant actions, and have state and factsheet sent again."""
        self._publish("connection", {"connectionState": "ONLINE"})
        self._client.subscribe(self._sender.topic("instantActions"))
        with self._lock:
            self._sent_state, self._sent_wheels = {}, {}

    def _carry_out(self, message: MQTTMessage) -> None:
        """Carry out the instant actions of a message; a malformed message is logged."""
        try:
            actions = json.loads(message.payload)["actions"]
            states = [action_state(action) for action in actions]
        except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
            _log.warning("a message on %s is no instantActions", message.topic)
            return
        with self._lock:
            self._actions = [*self._actions, *states][-KEPT_ACTIONS:]
            self._sent_state = {}  # the state follows with the action's, as the standard asks
            if any(state["actionType"] == "factsheetRequest" for state in states):
                self._sent_wheels = {}

    def _send_factsheet(self) -> None:
        """Send the factsheet when it was asked for, or when the calibration has changed."""
        content = with_actions(self._sheet.with_wheels(self._vehicle()))
        with self._lock:
            if content == self._sent_wheels:
                return
            self._sent_wheels = content
        self._publish("factsheet", content)

    def _send_state(self) -> None:
        """Send the state when it has changed, and at least as often as the standard asks."""
        content = state_of(self._robot.status, self._actions)
        now = time.monotonic()
        with self._lock:
            if content == self._sent_state and now - self._sent_at < MAX_STATE_PERIOD:
                return
            self._sent_state, self._sent_at = content, now
        self._publish("state", content)

    def _publish(self, name: str, content: dict[str, Any]) -> MQTTMessageInfo:
        """Publish a message; the broker keeps that of the connection, as the standard asks."""
        text = json.dumps(self._sender.message(name, content, time.time()), allow_nan=False)
        is_kept = name == "connection"
        return self._client.publish(self._sender.topic(name), text, qos=int(is_kept), retain=is_kept)


def _client(url: str) -> tuple[Client, str, int]:
    """Return the client of a broker, with its host and port."""
    try:
        from paho.mqtt.client import Client
        from paho.mqtt.enums import CallbackAPIVersion
    except ImportError as error:
        raise BrokerError("mqtt", "MQTT needs paho-mqtt: pip install 'omnimate[mqtt]'") from error
    try:
        parts = urlsplit(url)
        host, port = parts.hostname, parts.port or (8883 if parts.scheme == "mqtts" else PORT)
    except ValueError as error:
        raise BrokerError("(as given)", f"no URL: {error}") from error
    if parts.scheme not in {"mqtt", "mqtts"} or host is None:
        raise BrokerError(parts._replace(netloc=host or "").geturl(), "no URL of a broker")
    client = Client(CallbackAPIVersion.VERSION2)
    if parts.scheme == "mqtts":
        client.tls_set()
    if parts.username is not None:
        client.username_pw_set(parts.username, parts.password)
    return client, host, port
