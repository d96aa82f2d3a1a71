"""The memory that the service's process returns to the system."""

import ctypes
import subprocess
import sys

import pytest

SIZE = 4_000_000  # [bytes] of a block
# Prints how much of a block is in pages of its own, after a block of the same size was freed: `hblkhd`, the
# fifth of ten counters (mallinfo(3)).
PROGRAM = f"""
import ctypes
from omnimate.service.processes import return_freed_memory

class Counters(ctypes.Structure):
    _fields_ = [("all", ctypes.c_size_t * 10)]

mallinfo2 = ctypes.CDLL(None).mallinfo2
mallinfo2.restype = Counters
{{call}}
block = bytes({SIZE})
del block
before = mallinfo2().all[4]
block = bytes({SIZE})
print(mallinfo2().all[4] - before)
"""


@pytest.mark.skipif(
    sys.platform != "linux" or not hasattr(ctypes.CDLL(None), "mallinfo2"), reason="needs glibc 2.33"
)
@pytest.mark.parametrize(
    ("call", "returned"), [("return_freed_memory()", True), ("", False)], ids=["set", "default"]
)
def test_a_large_block_goes_back_to_the_system_also_after_another_one(call, returned):
    """By default only the first one does: it raises the threshold."""
    program = [sys.executable, "-c", PROGRAM.format(call=call)]
    own = int(subprocess.run(program, capture_output=True, text=True, check=True).stdout)
    assert (own >= SIZE) is returned
