"""The server: a vehicle whose bus other processes join, until a signal ends it."""

import signal
import subprocess
import sys
import time
from pathlib import Path

import can

ROOT = Path(__file__).resolve().parents[2]
PATIENCE = 120.0  # [s]; an upper bound, never waited for
PROGRAM = """
from omnimate.vcan_sim.faults import parse_fault
from omnimate.vcan_sim.reference import reference_single
from omnimate.vcan_sim.server import serve

class Plant:
    counts = 0
    def step(self, wheel_speeds, dt):
        self.counts += 1
    def raw_counts(self):
        return self.counts, -self.counts

serve(reference_single(), Plant(), port=0, faults=[parse_fault("emcy:node=1,at=0.1")],
      on_ready=lambda port: print(port, flush=True))
print("ended")
"""


class Client:
    """A client of the bus, which keeps what it has received last of each COB-ID."""

    def __init__(self, bus):
        self.bus, self.seen = bus, {}

    def send(self, can_id, data=b""):
        self.bus.send(can.Message(arbitration_id=can_id, data=data, is_extended_id=False))

    def wait_for(self, can_id):
        """Return the data of the next frame of a COB-ID, which may have come already."""
        while can_id not in self.seen:
            message = self.bus.recv(PATIENCE)
            assert message is not None, f"no frame {can_id:03X}h; received {self.seen}"
            self.seen[message.arbitration_id] = bytes(message.data)
        return self.seen.pop(can_id)

    def last_error(self):
        """Return the newest error code of node 1 (1003h:1); None where the node has none yet."""
        self.send(0x601, bytes([0x40, 0x03, 0x10, 1, 0, 0, 0, 0]))
        answer = self.wait_for(0x581)
        return None if answer[0] == 0x80 else int.from_bytes(answer[4:], "little")


def test_another_process_drives_the_vehicle_and_a_signal_ends_the_server():
    with subprocess.Popen(
        [sys.executable, "-c", PROGRAM], cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as server:
        try:
            port = int(server.stdout.readline())
            with can.Bus("can0", interface="socketcand", host="127.0.0.1", port=port, tcp_tune=True) as bus:
                client, deadline = Client(bus), time.monotonic() + PATIENCE
                while (code := client.last_error()) is None:  # the fault's time passes without SYNC
                    assert time.monotonic() < deadline
                client.send(0x000, b"\x01\x00")
                client.send(0x080)
                left, right = client.wait_for(0x281), client.wait_for(0x282)
            server.send_signal(signal.SIGTERM)
            output, errors = server.communicate(timeout=PATIENCE)
        finally:
            server.kill()  # or leaving the block would wait for it for ever where a check has failed
    assert code == 0x5000
    assert right == (-int.from_bytes(left, "little") % 2**32).to_bytes(4, "little")
    assert (server.returncode, output, errors) == (0, "ended\n", "")
