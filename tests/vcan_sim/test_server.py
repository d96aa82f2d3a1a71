"""The server: a vehicle whose bus other processes join, until a signal ends it."""

import signal
import subprocess
import sys
from pathlib import Path

import can

ROOT = Path(__file__).resolve().parents[2]
PATIENCE = 30.0  # [s]; an upper bound, never waited for
PROGRAM = """
from vcan_sim.faults import parse_fault
from vcan_sim.reference import reference_single
from vcan_sim.server import serve

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


def test_another_process_drives_the_vehicle_and_a_signal_ends_the_server():
    with subprocess.Popen(
        [sys.executable, "-c", PROGRAM], cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as server:
        port = int(server.stdout.readline())
        with can.Bus("can0", interface="socketcand", host="127.0.0.1", port=port, tcp_tune=True) as bus:
            bus.send(can.Message(arbitration_id=0x000, data=b"\x01\x00", is_extended_id=False))
            bus.send(can.Message(arbitration_id=0x080, is_extended_id=False))
            seen = {}
            while not {0x281, 0x282, 0x081} <= seen.keys():
                message = bus.recv(PATIENCE)
                seen.setdefault(message.arbitration_id, bytes(message.data))
        server.send_signal(signal.SIGTERM)
        output, errors = server.communicate(timeout=PATIENCE)
    counts = int.from_bytes(seen[0x281], "little")
    assert seen[0x282] == (-counts % 2**32).to_bytes(4, "little")
    assert seen[0x081][:2] == b"\x00\x50"  # the fault's time passed without SYNC
    assert (server.returncode, output, errors) == (0, "ended\n", "")
