"""The robot by VDA 5050: its messages, and the real ones at a broker where one answers."""

import json
import queue
import secrets
import socket
from collections import defaultdict
from contextlib import contextmanager
from types import SimpleNamespace

import pytest

from omnimate.driver.robot.events import Trouble
from omnimate.driver.robot.report import DriverReport
from omnimate.service.components import Components
from omnimate.service.robot.robot_server import RobotStatus
from omnimate.service.settings import Settings
from omnimate.service.vda5050.factsheet import REQUIRED, FactsheetError, load_factsheet
from omnimate.service.vda5050.messages import Sender, action_state, state_of, with_actions
from omnimate.service.vda5050.publisher import BrokerError, Publisher
from omnimate.vcan_sim.reference import reference_vehicle
from tests.service.conftest import serving

paho = pytest.importorskip("paho.mqtt.client", reason="paho-mqtt is not installed")

BROKER = "127.0.0.1", 1883
MOST_MESSAGES = 20  # of a topic among which the awaited one must be
# Chapter 6.10 (state) of VDA 5050 2.1: what is not optional.
STATE = {
    *("orderId", "orderUpdateId", "lastNodeId", "lastNodeSequenceId", "nodeStates", "edgeStates", "driving"),
    *("actionStates", "batteryState", "operatingMode", "errors", "safetyState"),
}
HEADER = {"headerId", "timestamp", "version", "manufacturer", "serialNumber"}
SHEET = {
    "manufacturer": "OmniMate",
    "serialNumber": "0001",
    "typeSpecification": {
        "seriesName": "OmniMate", "agvKinematic": "DIFF", "agvClass": "TUGGER", "maxLoadMass": 100.0,
        "localizationTypes": ["NATURAL"], "navigationTypes": ["AUTONOMOUS"],
    },
    "physicalParameters": {
        "speedMin": 0.01, "speedMax": 1.0, "accelerationMax": 0.5, "decelerationMax": 0.5,
        "heightMin": 0.3, "heightMax": 0.3, "width": 0.5, "length": 1.6,
    },
    "protocolLimits": {
        "maxStringLens": {}, "maxArrayLens": {}, "timing": {"minOrderInterval": 1.0, "minStateInterval": 1.0},
    },
    "protocolFeatures": {"optionalParameters": [], "agvActions": []},
    "agvGeometry": {"wheelDefinitions": [{"type": "DRIVE", "width": 0.045}], "envelopes2d": []},
    "loadSpecification": {},
}  # fmt: skip


@pytest.fixture
def sheet(tmp_path):
    """A factsheet's file, with a serial number of its own."""
    path = tmp_path / "factsheet.json"
    path.write_text(json.dumps(SHEET | {"serialNumber": secrets.token_hex(4)}))
    return path


def stopped_by(**trouble):
    """A report of the driver after a drive's trouble."""
    return DriverReport(0.0, 1, 0, (), (), 0, (), (), (Trouble(1.0, 9, "stopped", **trouble),))


def test_a_state_has_all_that_the_standard_requires_and_says_what_is_not_known():
    seen = {
        "driving": None,
        "wheels": [0.0, 0.0],
        "plain": {"x": 1.0, "y": 2.0, "theta": 7.0},
        "filter": None,
    }
    state = state_of(RobotStatus(None, state=seen), [])
    assert set(state) >= STATE
    assert state["agvPosition"]["x"] == 1.0
    assert abs(state["agvPosition"]["theta"]) <= 3.2
    assert (state["driving"], state["operatingMode"], state["errors"]) == (False, "SERVICE", [])
    assert "not known" in state["information"][0]["infoDescription"]
    assert state["safetyState"]["eStop"] == "NONE"
    assert state_of(RobotStatus(None, state=seen | {"wheels": [0.0, -1.0]}), [])["driving"]


def test_a_robot_that_cannot_be_read_has_a_fatal_error_and_no_position():
    state = state_of(RobotStatus("no adapter"), [])
    assert "agvPosition" not in state
    assert [error["errorLevel"] for error in state["errors"]] == ["FATAL"]


@pytest.mark.parametrize(
    ("status", "stop"),
    [
        (0x0007, "MANUAL"),  # quick stop active, which this driver has not commanded
        (0x0240, "MANUAL"),  # switch on disabled: the power was taken away
        (0x0008, "NONE"),  # a fault of the drive itself
        (0x000F, "NONE"),  # its reaction to one
        (None, "NONE"),  # a lost heartbeat, an EMCY
    ],
)
def test_a_drive_that_was_stopped_from_outside_is_an_emergency_stop(status, stop):
    state = state_of(RobotStatus(None, report=stopped_by(status=status)), [])
    assert state["safetyState"] == {"eStop": stop, "fieldViolation": False}
    assert [error["errorLevel"] for error in state["errors"]] == ["FATAL"]


@pytest.mark.parametrize(("code", "charge"), [(0x3220, 20.0), (0x3121, 20.0), (0x3210, 80.0), (None, 80.0)])
def test_a_low_voltage_that_a_drive_tells_of_is_a_bad_battery(code, charge):
    state = state_of(RobotStatus(None, report=stopped_by(emergency=code)), [])
    assert state["batteryState"]["batteryCharge"] == charge


def test_headers_count_the_messages_of_each_topic():
    sender = Sender("OmniMate", "0001")
    first, second = (sender.message("state", {"driving": True}, 1.5) for _ in range(2))
    other = sender.message("factsheet", {}, 1.5)
    assert [message["headerId"] for message in (first, second, other)] == [0, 1, 0]
    assert set(first) == HEADER | {"driving"}
    assert first["timestamp"] == "1970-01-01T00:00:01.500Z"
    assert sender.topic("state") == "uagv/v2/OmniMate/0001/state"


def test_a_factsheet_has_the_calibrated_wheels_and_keeps_what_the_manufacturer_states(sheet):
    content = with_actions(load_factsheet(sheet).with_wheels(reference_vehicle()))
    assert set(content) == set(REQUIRED)
    wheels = content["agvGeometry"]["wheelDefinitions"]
    truck = reference_vehicle().trucks["a"]
    assert [wheel["diameter"] for wheel in wheels[:2]] == [
        truck.wheel_diameter_left,
        truck.wheel_diameter_right,
    ]
    assert wheels[0]["position"]["y"] - wheels[1]["position"]["y"] == pytest.approx(truck.wheelbase)
    assert {wheel["width"] for wheel in wheels} == {0.045}
    assert content["physicalParameters"] == SHEET["physicalParameters"]
    assert content["agvGeometry"]["envelopes2d"] == []
    actions = [action["actionType"] for action in content["protocolFeatures"]["agvActions"]]
    assert actions == ["factsheetRequest", "stateRequest"]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (json.dumps(SHEET | {"serialNumber": "a/b"}), "serialNumber"),
        (json.dumps(SHEET | {"physicalParameters": {"speedMin": 0.0}}), "speedMax"),
        (json.dumps(SHEET | {"loadSpecification": None}), "loadSpecification is missing"),
        (json.dumps(SHEET | {"agvGeometry": {}}), "width in metres"),
        ("[" * 100_000, "cannot be read as JSON"),
    ],
    ids=["serial", "speed", "load", "wheels", "too deep"],
)
def test_a_factsheet_that_lacks_something_is_refused_with_what_it_lacks(tmp_path, text, words):
    path = tmp_path / "factsheet.json"
    path.write_text(text)
    with pytest.raises(FactsheetError, match=words):
        load_factsheet(path)


@pytest.mark.parametrize("payload", [b"{", b"[]", b"[" * 100_000], ids=["cut off", "list", "too deep"])
def test_a_message_that_holds_no_actions_is_logged(caplog, payload):
    message = SimpleNamespace(payload=payload, topic="uagv/v2/maker/1/instantActions")
    Publisher._carry_out(SimpleNamespace(), message)
    assert "is no instantActions" in caplog.text


def test_an_action_that_is_not_known_fails_and_says_which_are():
    assert action_state({"actionId": "1", "actionType": "factsheetRequest"})["actionStatus"] == "FINISHED"
    refused = action_state({"actionId": "2", "actionType": "pick"})
    assert refused["actionStatus"] == "FAILED"
    assert "stateRequest" in refused["resultDescription"]


@pytest.mark.parametrize("url", ["http://host", "mqtt://", "mqtt://host:port"])
def test_what_is_no_url_of_a_broker_is_refused(tmp_path, sheet, url):
    with pytest.raises(BrokerError, match="mqtt://"):
        Components(Settings(database=f"sqlite:///{tmp_path}/x.db", mqtt=url, factsheet=sheet))


def test_a_broker_without_a_factsheet_is_refused(tmp_path):
    with pytest.raises(BrokerError, match="--factsheet"):
        Components(Settings(database=f"sqlite:///{tmp_path}/x.db", mqtt="mqtt://127.0.0.1"))


@pytest.fixture
def broker():
    """The URL of the broker of this machine; skipped where none answers."""
    try:
        socket.create_connection(BROKER, 2.0).close()
    except OSError:
        pytest.skip(f"no MQTT broker answers at {BROKER[0]}:{BROKER[1]}")
    return f"mqtt://{BROKER[0]}:{BROKER[1]}"


@contextmanager
def manager(serial):
    """A fleet manager: returns a function that awaits a message, and one that asks for an action."""
    topic, messages, ready = f"uagv/v2/OmniMate/{serial}", defaultdict(queue.Queue), queue.Queue()
    client = paho.Client(paho.CallbackAPIVersion.VERSION2)

    def received(_client, _data, message):
        if message.payload:  # what is kept for later is taken back by an empty one
            messages[message.topic.rpartition("/")[2]].put(json.loads(message.payload))

    client.on_message = received
    client.on_connect = lambda *_: client.subscribe(f"{topic}/#", qos=1)
    client.on_subscribe = lambda *_: ready.put(True)
    client.connect(*BROKER)
    client.loop_start()
    ready.get(timeout=60.0)

    def await_message(name, true=lambda _content: True):
        for _ in range(MOST_MESSAGES):
            content = messages[name].get(timeout=60.0)
            if true(content):
                return content
        raise AssertionError(f"not among {MOST_MESSAGES} messages of {name}")

    def ask(action, identity):
        content = {"actions": [{"actionType": action, "actionId": identity, "blockingType": "NONE"}]}
        client.publish(f"{topic}/instantActions", json.dumps(content))

    try:
        yield await_message, ask
    finally:
        client.publish(f"{topic}/connection", "", retain=True)  # leaves nothing at the broker
        client.disconnect()
        client.loop_stop()


@pytest.mark.slow
def test_a_fleet_manager_sees_the_robot_asks_for_its_factsheet_and_gets_a_new_calibration(
    broker, sheet, tmp_path
):
    serial = json.loads(sheet.read_text())["serialNumber"]
    with manager(serial) as (await_message, ask):
        with serving(f"sqlite:///{tmp_path}/x.db", mqtt=broker, factsheet=sheet) as client:
            assert await_message("connection")["connectionState"] == "ONLINE"
            state = await_message("state", lambda content: "agvPosition" in content)
            assert set(state) >= STATE | HEADER
            assert len(await_message("factsheet")["agvGeometry"]["wheelDefinitions"]) == 4
            ask("factsheetRequest", "a1")
            assert await_message("factsheet")["version"] == "2.1.0"
            ask("pick", "a2")
            states = await_message("state", lambda content: len(content["actionStates"]) == 2)["actionStates"]
            assert [action["actionStatus"] for action in states] == ["FINISHED", "FAILED"]
            toml = (
                client.get("/v1/vehicles/omnimate")
                .json()["toml"]
                .replace("wheelbase = 0.34", "wheelbase = 0.337")
            )
            headers = {"If-Match": "*", "Content-Type": "application/toml"}
            assert client.put("/v1/vehicles/omnimate", content=toml, headers=headers).status_code == 200
            wheels = await_message("factsheet")["agvGeometry"]["wheelDefinitions"]
            assert wheels[0]["position"]["y"] == pytest.approx(0.337 / 2)
        assert await_message("connection")["connectionState"] == "OFFLINE"


def test_a_robot_whose_connection_breaks_is_told_broken_by_the_broker(broker, sheet, tmp_path):
    serial = json.loads(sheet.read_text())["serialNumber"]
    publisher = Publisher(broker, load_factsheet(sheet), None, reference_vehicle)
    publisher._ending.set()  # there is no robot: its thread ends at once, the connection stays
    with manager(serial) as (await_message, _):
        publisher.start()
        assert await_message("connection")["connectionState"] == "ONLINE"
        publisher._client.loop_stop()
        publisher._client.socket().close()  # without a word, as when the power fails
        assert await_message("connection")["connectionState"] == "CONNECTIONBROKEN"
