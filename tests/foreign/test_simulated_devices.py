"""The simulated devices as canopen's own master sees them: SDO with blocks, PDO, NMT, EMCY, LSS."""

from __future__ import annotations

import io
import struct

import can
import canopen
import pytest

from docs.generate.conformance import BenchBus, Simulated
from omnimate.vcan_sim.nodes.objects import EDS_FOLDER
from omnimate.vcan_sim.reference import reference_vehicle

NODE = reference_vehicle().encoders[0].node


class Master(canopen.Network):
    """canopen's network, whose frames are answered before `send_message` returns."""

    def __init__(self):
        super().__init__()
        self.bench = BenchBus(Simulated)
        while self.bench.recv(0.0):  # the boot-ups
            pass
        self.subscribe(self.lss.LSS_RX_COBID, self.lss.on_message_received)

    def send_message(self, can_id, data, remote=False):
        frame = can.Message(
            arbitration_id=can_id, data=None if remote else bytes(data), dlc=len(data) or remote,
            is_remote_frame=remote, is_extended_id=False,
        )  # fmt: skip
        self.bench.send(frame)
        self.receive()

    def receive(self):
        """Take what the devices have sent."""
        while (answer := self.bench.recv(0.0)) is not None:
            self.notify(answer.arbitration_id, bytearray(answer.data), answer.timestamp)


@pytest.fixture
def master(monkeypatch):
    monkeypatch.setattr("canopen.lss.time.sleep", lambda _seconds: None)
    network = Master()
    network.lss.RESPONSE_TIMEOUT = 0.001
    return network


@pytest.fixture
def node(master):
    remote = canopen.RemoteNode(NODE, str(EDS_FOLDER / "encoder_cia406.eds"))
    master.add_node(remote)
    return remote


def test_a_name_is_uploaded_in_segments_and_in_a_block(node):
    in_segments = node.sdo.upload(0x1008, 0)
    with node.sdo.open(0x1008, 0, "rb", block_transfer=True) as stream:
        in_a_block = io.BytesIO(stream.read()).getvalue()
    assert in_segments == in_a_block == b"OmniMate multi-turn encoder"


@pytest.mark.parametrize("way", [{}, {"force_segment": True}, {"block_transfer": True}])
def test_a_number_is_downloaded_expedited_in_a_segment_and_in_a_block(node, way):
    with node.sdo.open(0x1017, 0, "wb", buffering=7, size=2, **way) as stream:
        stream.write(struct.pack("<H", 777))
    assert node.sdo[0x1017].raw == 777


def test_a_pdo_is_mapped_and_received(master, node):
    node.tpdo.read()
    pdo = node.tpdo[1]
    pdo.clear()
    pdo.add_variable(0x6004)
    pdo.add_variable(0x6500)
    pdo.trans_type = 1
    pdo.save()
    node.nmt.state = "OPERATIONAL"
    master.bench._devices._latch.take((77,) * 7)
    master.sync.transmit()
    assert (pdo[0].raw, pdo[1].raw, pdo.is_periodic) == (77, 0, True)


def test_a_boot_up_and_an_emergency_are_received(master, node):
    states = []
    node.nmt.add_heartbeat_callback(states.append)
    node.nmt.send_command(0x81)
    assert states == [0]
    master.bench._devices._devices[0].emergency.set(0x5000)
    master.receive()
    assert [error.code for error in node.emcy.active] == [0x5000]


def test_a_download_of_a_wrong_length_or_of_a_read_only_object_is_aborted(node):
    for data in (b"\1", b"\1\2\3", bytes(9)):
        with pytest.raises(canopen.SdoAbortedError) as caught:
            node.sdo.download(0x1017, 0, data)
        assert caught.value.code == 0x06070010
    with pytest.raises(canopen.SdoAbortedError) as caught:
        node.sdo.download(0x1000, 0, bytes(4))
    assert caught.value.code == 0x06010002


def test_nmt_states_and_guarding_are_those_that_canopen_reads(master, node):
    for state in ("OPERATIONAL", "STOPPED", "PRE-OPERATIONAL"):
        node.nmt.state = state
        node.nmt._state = 0
        master.send_message(0x700 + NODE, b"", remote=True)  # node guarding
        assert node.nmt.state == state


def test_parameters_are_stored_and_restored_by_canopens_methods(node):
    node.sdo[0x1017].raw = 777
    node.store()
    node.nmt.state = "RESET"
    assert node.sdo[0x1017].raw == 777
    node.restore()
    node.nmt.state = "RESET"
    assert node.sdo[0x1017].raw == 0


def test_canopens_lss_master_takes_an_id_away_finds_the_device_and_gives_it_back(master, node):
    identity = [node.sdo[0x1018][sub].raw for sub in (1, 2, 3, 4)]
    lss = master.lss
    assert lss.fast_scan() == (False, None)
    assert lss.send_switch_state_selective(*identity)
    assert lss.inquire_node_id() == NODE
    assert [lss.inquire_lss_address(command) for command in (0x5A, 0x5B, 0x5C, 0x5D)] == identity
    lss.configure_node_id(255)
    lss.store_configuration()
    lss.send_switch_state_global(lss.WAITING_STATE)
    node.nmt.state = "RESET COMMUNICATION"
    with pytest.raises(canopen.SdoCommunicationError):
        node.sdo.upload(0x1000, 0)
    found, scanned = lss.fast_scan()
    assert (found, scanned) == (True, identity)
    lss.configure_node_id(NODE)
    lss.send_switch_state_global(lss.WAITING_STATE)
    assert node.sdo[0x1000].raw & 0xFFFF == 406
