"""CANopen devices on `canopen.LocalNode`, which nobody of this project wrote.

SDO, the object dictionary and EMCY are canopen's own. What a LocalNode leaves to the application is here: NMT
states with boot-up, PDOs by their mapping, heartbeats, and the state machine of a drive.
"""

from __future__ import annotations

import ctypes
import math
from types import SimpleNamespace

import canopen
from canopen.objectdictionary import (
    INTEGER8,
    INTEGER32,
    UNSIGNED8,
    UNSIGNED16,
    UNSIGNED32,
    ObjectDictionary,
    ODRecord,
    ODVariable,
)

from omnimate.driver.canopen.eds import load_eds

STOPPED, OPERATIONAL, PRE_OPERATIONAL = 0x04, 0x05, 0x7F
NMT_STATE = {0x01: OPERATIONAL, 0x02: STOPPED, 0x80: PRE_OPERATIONAL}
RESET_NODE, RESET_COMMUNICATION = 0x81, 0x82
SWITCH_ON_DISABLED, READY, SWITCHED_ON, ENABLED = 0x0240, 0x0221, 0x0223, 0x0227
QUICK_STOP_ACTIVE, FAULT, FAULT_REACTION = 0x0207, 0x0208, 0x020F
RAMP = 400_000.0  # [counts/s^2] of a drive, also in a quick stop


class ForeignNetwork(canopen.Network):
    """canopen's network without its threads: `Bench` hands it the frames, and nodes time their heartbeats.

    Attributes:
        hearers: What hears every frame: its identifier, its data and the time.
    """

    def __init__(self, bus=None):
        super().__init__(bus)
        self.hearers = []

    def notify(self, can_id, data, timestamp):
        super().notify(can_id, data, timestamp)
        for hear in self.hearers:
            hear(can_id, data, timestamp)

    def send_periodic(self, can_id, data, period, remote=False):
        """Do nothing: the node counts its heartbeats itself."""
        return SimpleNamespace(stop=lambda: None, update=lambda _data: None)


class ForeignNode(canopen.LocalNode):
    """A node with NMT states, heartbeats and TPDOs.

    Attributes:
        writes: What was written by SDO, also in vain: index, sub-index, value.
        refuse: Abort codes of writing, by index and sub-index, or by these and a value.
        refuse_read: Abort codes of reading, by index and sub-index.
    """

    device_type = 0
    objects = (
        (0x1001, 0, UNSIGNED8, "ro", 0),
        (0x1005, 0, UNSIGNED32, "rw", 0x80),
        (0x1006, 0, UNSIGNED32, "rw", 0),
        (0x1017, 0, UNSIGNED16, "rw", 0),
        (0x1018, 0, UNSIGNED8, "ro", 4),
        *((0x1018, sub, UNSIGNED32, "ro", 0x300 + sub) for sub in range(1, 5)),
        (0x1019, 0, UNSIGNED8, "rw", 0),
    )

    def __init__(self, node, extra=(), tpdos=(), described=None):
        device_type = (0x1000, 0, UNSIGNED32, "ro", self.device_type)
        made = dictionary([device_type, *self.objects, *extra, *pdo_objects(node, 0x1800, tpdos)])
        super().__init__(node, described or made)
        self.state = PRE_OPERATIONAL
        self.is_powered = self.hears_sync = True
        self.writes, self.refuse, self.refuse_read = [], {}, {}
        self.now = 0.0
        self._beat, self._period = math.inf, 0.0
        self._event_pdos = None  # TPDOs that are sent at a change; None where they must be read again
        self._sent = {}

    def _find_object(self, index, subindex):
        variable = super()._find_object(index, subindex)
        if variable.subindex != subindex:  # canopen takes any for an object without sub-indices
            raise canopen.SdoAbortedError(0x06090011)
        return variable

    def get_data(self, index, subindex, check_readable=False):
        """Return the bytes of an object, which may be refused to SDO: `check_readable`."""
        if check_readable and (index, subindex) in self.refuse_read:
            raise canopen.SdoAbortedError(self.refuse_read[index, subindex])
        return super().get_data(index, subindex, check_readable)

    def set_data(self, index, subindex, data, check_writable=False):
        """Take what SDO writes, unless it is refused."""
        value = int.from_bytes(data, "little")
        self.writes.append((index, subindex, value))
        if code := self.refuse.get((index, subindex)) or self.refuse.get((index, subindex, value)):
            raise canopen.SdoAbortedError(code)
        super().set_data(index, subindex, data, check_writable)
        self._event_pdos = None
        self.on_write(index, subindex, value)

    def on_write(self, index, subindex, value):
        """Follow what SDO has written."""

    def associate_network(self, network):
        super().associate_network(network)
        network.unsubscribe(self.sdo.rx_cobid, self.sdo.on_request)
        network.unsubscribe(0, self.nmt.on_command)
        network.subscribe(self.sdo.rx_cobid, self._on_sdo)
        network.subscribe(0, self._on_nmt)
        network.subscribe(0x80, self._on_sync)

    def number(self, index, subindex=0):
        """Return an object as an unsigned number."""
        return int.from_bytes(self.get_data(index, subindex), "little")

    def put(self, index, subindex, value):
        """Set an object to an unsigned number."""
        size = len(self.get_data(index, subindex))
        self.store(index, subindex, (value % (1 << 8 * size)).to_bytes(size, "little"))

    def store(self, index, subindex, data):
        """Set an object to its bytes."""
        self.data_store.setdefault(index, {})[subindex] = data

    def protect(self, index, subindex=0):
        """Refuse to write an object."""
        self.object_dictionary.get_variable(index, subindex).access_type = "ro"

    def send(self, can_id, data):
        """Send a frame, unless the node is without power."""
        if self.is_powered:
            self.network.send_message(can_id, data)

    def reset(self):
        """Restart with the defaults of all objects, as the return of the power does."""
        self.is_powered = True
        self.data_store.clear()
        self._sent.clear()
        self._beat, self._event_pdos = math.inf, None
        self.state = PRE_OPERATIONAL
        self.send(0x700 + self.id, b"\0")

    def power_off(self):
        """Stop sending and hearing."""
        self.is_powered = False

    def tick(self, now):
        """Let time pass until `now` [s]: heartbeats and TPDOs at a change."""
        self.now = now
        if self._event_pdos is None:
            self._event_pdos = self._pdos(lambda kind: kind >= 254)
            self._period = self.number(0x1017) / 1000.0
            self._beat = min(self._beat, now + self._period) if self._period else math.inf
        if now >= self._beat:
            self._beat += self._period
            self.send(0x700 + self.id, bytes((self.state,)))
        for cob_id, entries in self._event_pdos:
            data = self._pack(entries)
            if data != self._sent.get(cob_id) and self.state == OPERATIONAL:
                self._sent[cob_id] = data
                self.send(cob_id, data)

    def _on_sdo(self, can_id, data, timestamp):
        if self.is_powered and self.state != STOPPED:
            self.sdo.on_request(can_id, data, timestamp)

    def _on_nmt(self, _can_id, data, _timestamp):
        if not self.is_powered or data[1] not in {0, self.id}:
            return
        if data[0] == RESET_NODE:
            self.reset()
        elif data[0] == RESET_COMMUNICATION:
            for index in [index for index in self.data_store if index < 0x2000]:
                del self.data_store[index]
            self.state, self._beat, self._event_pdos = PRE_OPERATIONAL, math.inf, None
            self.send(0x700 + self.id, b"\0")
        else:
            self.state = NMT_STATE.get(data[0], self.state)

    def _on_sync(self, _can_id, _data, _timestamp):
        if self.state == OPERATIONAL and self.hears_sync:
            for cob_id, entries in self._pdos(lambda kind: kind == 1):
                self.send(cob_id, self._pack(entries))

    def _pdos(self, is_due):
        """Return COB-ID and entries of the TPDOs of some transmission types that are switched on."""
        bases = [base for base in range(0x1800, 0x1804) if base in self.object_dictionary]
        return [
            (self.number(base, 1) & 0x7FF, self._entries(base + 0x200))
            for base in bases
            if not self.number(base, 1) >> 31 and is_due(self.number(base, 2))
        ]

    def _pack(self, entries):
        word = bit = 0
        for entry in entries:
            word |= (self.number(entry >> 16, entry >> 8 & 0xFF) % (1 << (entry & 0xFF))) << bit
            bit += entry & 0xFF
        return word.to_bytes((bit + 7) // 8, "little")

    def _entries(self, mapping):
        return [self.number(mapping, sub) for sub in range(1, self.number(mapping, 0) + 1)]


class DescribedNode(ForeignNode):
    """A device with all objects of an EDS and their defaults; a text that has none reads as a name."""

    def __init__(self, node, path, identity=None):
        super().__init__(node, described=load_eds(path, node).dictionary)
        self.identity = identity
        self.add_read_callback(self._read)

    def number(self, index, subindex=0):
        """Return an object as an unsigned number, 0 where it has no value."""
        try:
            return super().number(index, subindex)
        except canopen.SdoAbortedError:
            return 0

    def _read(self, *, index, subindex, **_):
        if index == 0x1018 and self.identity and 0 < subindex <= len(self.identity):
            return self.identity[subindex - 1]
        return "device of an EDS" if index == 0x1008 else None


class ForeignEncoder(ForeignNode):
    """A CiA 406 encoder; `position` counts on while it has power."""

    device_type = 0x00020196

    def __init__(self, node, kind=254, more=()):
        extra = [
            *more,
            (0x6000, 0, UNSIGNED16, "rw", 0),
            (0x6004, 0, UNSIGNED32, "ro", 0),
            (0x6500, 0, UNSIGNED16, "ro", 0),
        ]
        super().__init__(node, extra, [(0x180 + node, kind, (0x60040020,)), (0x80000280 + node, 1, ())])
        self.position = 0.0
        self.add_read_callback(self._read)

    def reset(self):
        """Count from 0 again."""
        super().reset()
        self.position = 0.0

    def _read(self, *, index, subindex, **_):
        return round(self.position) % 2**32 if index == 0x6004 else None


class DrivenWheel:
    """The wheel of a drive of either family: it follows the target by a ramp, and its encoder counts."""

    velocity, is_blocked = 0.0, False

    def tick(self, now):
        """Turn the wheel until `now` [s]."""
        seconds = now - self.now
        super().tick(now)
        is_turning = self.status == ENABLED and self.state == OPERATIONAL
        target = float(ctypes.c_int32(self.number(0x60FF)).value) if is_turning else 0.0
        step = RAMP * seconds
        self.velocity = max(self.velocity - step, min(self.velocity + step, target))
        if not self.is_blocked:
            self.encoder.position += self.velocity * seconds

    def fault(self, code=None):
        """Go to fault and let the wheel run down; with `code` send EMCY."""
        self.status = FAULT
        if code is not None:
            self.emergency(code)

    def power_off(self):
        """Stop sending and hearing; the wheel runs down."""
        super().power_off()
        self.status = SWITCH_ON_DISABLED


class ForeignDrive(DrivenWheel, ForeignNode):
    """A CiA 402 drive that turns the wheel of `encoder`.

    `status` says where its status word is: None in no TPDO, "first" or "last" in an enabled one. `rpdo` is
    what its RPDO maps, `access` whether that can be changed, and `more` further objects.
    """

    device_type = 0x00020192

    def __init__(self, node, encoder, status=None, rpdo=(0x60400010,), access="rw", more=()):
        extra = [
            *more,
            (0x1016, 0, UNSIGNED8, "ro", 1),
            (0x1016, 1, UNSIGNED32, "rw", 0),
            (0x6007, 0, UNSIGNED16, "rw", 1),
            (0x6040, 0, UNSIGNED16, "rw", 0),
            (0x6041, 0, UNSIGNED16, "ro", 0),
            (0x6060, 0, INTEGER8, "rw", 0),
            (0x6061, 0, INTEGER8, "ro", 0),
            (0x60FF, 0, INTEGER32, "rw", 0),
            *pdo_objects(node, 0x1400, [(0x200 + node, 255, rpdo)], access),
        ]
        mapped = {"first": (0x60410010, 0x60610008), "last": (0x60610008, 0x60410010)}.get(status, ())
        super().__init__(node, extra, [((0 if status else 1 << 31) | 0x180 + node, 255, mapped)])
        self.encoder = encoder
        self.status = SWITCH_ON_DISABLED
        self.add_read_callback(self._read)

    def emergency(self, code):
        """Send EMCY and stay as it is."""
        if self.is_powered:
            self.emcy.send(code, 0x01)

    def reset(self):
        """Stand without torque."""
        super().reset()
        self.status = SWITCH_ON_DISABLED

    def associate_network(self, network):
        super().associate_network(network)
        network.hearers.append(self._on_rpdo)

    def _on_rpdo(self, can_id, data, _timestamp):
        if not self.is_powered or self.state != OPERATIONAL or not 0x200 <= can_id < 0x580:
            return
        if can_id != self.number(0x1400, 1):
            return
        word = int.from_bytes(data, "little")
        for entry in self._entries(0x1600):
            bits, index = entry & 0xFF, entry >> 16
            if index > 0x0007:  # not a dummy, which fills a gap
                self.put(index, entry >> 8 & 0xFF, word & (1 << bits) - 1)
            word >>= bits
            if index == 0x6040:
                self._control(self.number(0x6040))

    def _read(self, *, index, subindex, **_):
        if index == 0x6041:
            return self.status
        return self.number(0x6060) if index == 0x6061 else None

    def on_write(self, index, subindex, value):
        """Follow what SDO has written: the control word."""
        if index == 0x6040:
            self._control(value)

    def _control(self, word):
        """Follow a control word, CiA 402-2 figure 9."""
        if self.status == FAULT_REACTION:
            return
        if self.status == FAULT:
            if word & 0x80:
                self.status = SWITCH_ON_DISABLED
        elif not word & 0x02:
            self.status = SWITCH_ON_DISABLED
        elif not word & 0x04:
            is_stopping = self.status in {ENABLED, QUICK_STOP_ACTIVE}
            self.status = QUICK_STOP_ACTIVE if is_stopping else SWITCH_ON_DISABLED
        elif word & 0x07 == 0x06 and self.status != QUICK_STOP_ACTIVE:
            self.status = READY
        elif word & 0x0F == 0x07 and self.status in {READY, ENABLED}:
            self.status = SWITCHED_ON
        elif word & 0x0F == 0x0F and self.status in {READY, SWITCHED_ON}:
            self.status = ENABLED


def pdo_objects(node, base, pdos, access="rw"):
    """Return the objects of PDOs, given as COB-ID with its upper bits, transmission type and entries.

    `access` is that of their mapping.
    """
    objects = []
    for number, (cob_id, kind, entries) in enumerate(pdos):
        communication, mapping = base + number, base + 0x200 + number
        objects += [
            (communication, 0, UNSIGNED8, "ro", 5),
            (communication, 1, UNSIGNED32, "rw", cob_id),
            (communication, 2, UNSIGNED8, "rw", kind),
            (communication, 3, UNSIGNED16, "rw", 0),
            (communication, 5, UNSIGNED16, "rw", 0),
            (mapping, 0, UNSIGNED8, access, len(entries)),
            *((mapping, sub, UNSIGNED32, access, (*entries, *[0] * 4)[sub - 1]) for sub in range(1, 5)),
        ]
    return objects


def dictionary(objects):
    """Return an object dictionary of index, sub-index, type, access and default."""
    made = ObjectDictionary()
    for index in sorted({index for index, *_ in objects}):
        record = ODRecord(f"Object {index:04X}h", index)
        for _, subindex, data_type, access, default in (row for row in objects if row[0] == index):
            variable = ODVariable(f"Value {subindex}", index, subindex)
            variable.data_type, variable.access_type, variable.default = data_type, access, default
            record.add_member(variable)
        single = len(record.subindices) == 1 and 0 in record.subindices
        made.add_object(record.subindices[0] if single else record)
    return made
