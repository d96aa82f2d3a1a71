"""The nominal robot: the checked content of `vehicle.toml`.

`wheelbase` is the distance between the contact points of the two drive wheels of one truck, as in the
papers; car makers call it track. Lengths in metres, angles in radians, times in seconds.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, replace
from typing import Literal, get_args

from omnimate.vehicle.errors import TableError

TruckName = Literal["a", "b"]
Channel = Literal["a.left", "a.right", "b.left", "b.right", "joint_a", "joint_b", "link"]
Profile = Literal["cia406", "cia402"]

TRUCKS: tuple[TruckName, ...] = get_args(TruckName)
CHANNELS: tuple[Channel, ...] = get_args(Channel)
WHEELS: tuple[Channel, ...] = CHANNELS[:4]
JOINTS: tuple[Channel, ...] = ("joint_a", "joint_b")
_OBJECT = re.compile(r"(?:0x)?([0-9A-Fa-f]{4})h?(?::(?:0x)?([0-9A-Fa-f]{1,2})h?)?")


class ParameterError(TableError):
    """A value that no robot can have; its key is the parameter's name inside its table."""


def _number(key: str, value: float, low: float, high: float, unit: str) -> None:
    """Raise an error if a value is not finite, or outside of the range of possible robots."""
    if not math.isfinite(value):
        raise ParameterError(key, f"{value} is not a finite number; expected {low:g} to {high:g} {unit}")
    if not low <= value <= high:
        hint = ""
        if unit == "m" and low <= value / 1000.0 <= high:
            hint = f"; this looks like millimetres: write {value / 1000.0:g}"
        raise ParameterError(key, f"{value:g} is impossible; expected {low:g} to {high:g} {unit}{hint}")


def _pdo_cob_id(cob_id: int) -> None:
    """Raise an error if no PDO can have a COB-ID; robots that only resemble CANopen use any other."""
    _number("cob_id", cob_id, 0x001, 0x7FF, "(11-bit COB-ID)")
    if cob_id == 0x080:
        raise ParameterError("cob_id", "080h is that of SYNC; expected that of a PDO, such as 181h to 57Fh")


@dataclass(frozen=True, slots=True)
class Truck:
    """One differential-drive truck.

    Attributes:
        wheelbase: Distance between the contact points of the two drive wheels [m].
        wheel_diameter_left: Diameter of the left drive wheel [m].
        wheel_diameter_right: Diameter of the right drive wheel [m].
    """

    wheelbase: float
    wheel_diameter_left: float
    wheel_diameter_right: float

    def __post_init__(self) -> None:
        _number("wheelbase", self.wheelbase, 0.01, 10.0, "m")
        _number("wheel_diameter_left", self.wheel_diameter_left, 0.005, 3.0, "m")
        _number("wheel_diameter_right", self.wheel_diameter_right, 0.005, 3.0, "m")

    @property
    def radii(self) -> tuple[float, float]:
        """Radii of the left and of the right drive wheel [m]."""
        return 0.5 * self.wheel_diameter_left, 0.5 * self.wheel_diameter_right


@dataclass(frozen=True, slots=True)
class Linkage:
    """The compliant linkage between the trucks' centres.

    Attributes:
        length: Distance of the centres where the linear encoder reads its `zero` [m].
    """

    length: float

    def __post_init__(self) -> None:
        _number("length", self.length, 0.05, 20.0, "m")


SDO_TIMEOUT = 0.5  # [s]; devices with a slow memory take 0.4 s


@dataclass(frozen=True, slots=True)
class Bus:
    """The CAN bus.

    Attributes:
        bitrate: Bit rate of the bus [bit/s].
        sync_period: Time between two SYNC frames [s]; every SYNC opens one sample.
        sdo_timeout: Time in which a device must answer an SDO request [s]; it is asked three times.
    """

    bitrate: int
    sync_period: float
    sdo_timeout: float = SDO_TIMEOUT

    def __post_init__(self) -> None:
        _number("bitrate", self.bitrate, 10_000, 1_000_000, "bit/s")
        _number("sync_period", self.sync_period, 0.0005, 10.0, "s")
        _number("sdo_timeout", self.sdo_timeout, 0.001, 60.0, "s")


@dataclass(frozen=True, slots=True)
class Encoder:
    """One encoder and the position of its counts in a PDO.

    Attributes:
        channel: What the encoder measures: a wheel, a joint or the link.
        node: CANopen node id, 1 to 127.
        cob_id: COB-ID of the TPDO that carries it.
        start_bit: First bit in the PDO, little-endian as CiA 301 packs.
        bits: Width of the field in the PDO.
        signed: Whether the field is two's complement.
        sign: +1 or -1, so that a wheel that rolls forward counts up.
        counts_per_turn: Counts of one turn of the wheel or joint; None for the link.
        counts_per_metre: Counts per metre of the link; None elsewhere.
        zero: Raw counts at angle 0, or at `linkage.length`; not used for wheels.
        range: Counts after which the counter wraps (6002h), where that is not 2**bits.
        profile: The device profile: a CiA 406 encoder or the encoder of a CiA 402 drive.
        object: Object with the position, such as `6063h` or `6020h:1`; None for that of the profile.
        eds: Path of the EDS or DCF file of its node; None where there is none.
        vendor: Vendor id 1018h:1 that the device must show; None accepts any.
        product: Product code 1018h:2 that the device must show; None accepts any.
        serial: Serial number 1018h:4 that the device must show; None accepts any.
    """

    channel: Channel
    node: int
    cob_id: int
    start_bit: int
    bits: int
    signed: bool
    sign: int
    counts_per_turn: float | None = None
    counts_per_metre: float | None = None
    zero: int = 0
    range: int | None = None
    profile: Profile = "cia406"
    object: str | None = None
    eds: str | None = None
    vendor: int | None = None
    product: int | None = None
    serial: int | None = None

    def __post_init__(self) -> None:
        if self.channel not in CHANNELS:
            raise ParameterError(
                "channel", f"{self.channel!r} is unknown; expected one of {', '.join(CHANNELS)}"
            )
        _number("node", self.node, 1, 127, "(node id)")
        _pdo_cob_id(self.cob_id)
        _number("start_bit", self.start_bit, 0, 63, "(bit)")
        _number("bits", self.bits, 1, 64, "(bits)")
        if self.start_bit + self.bits > 64:
            raise ParameterError("bits", f"the field ends at bit {self.start_bit + self.bits}; a PDO has 64")
        if self.sign not in {1, -1}:
            raise ParameterError("sign", f"{self.sign} is neither 1 nor -1")
        if self.object is not None and not _OBJECT.fullmatch(self.object):
            raise ParameterError("object", f"{self.object!r}; expected an index such as 6063h, or 6020h:1")
        if self.range is not None and not 1 < self.range <= 2**self.bits:
            raise ParameterError(
                "range", f"{self.range} does not fit {self.bits} bits; expected 2 to {2**self.bits}"
            )
        self._check_scale()

    def _check_scale(self) -> None:
        wanted = "counts_per_metre" if self.channel == "link" else "counts_per_turn"
        other = "counts_per_turn" if self.channel == "link" else "counts_per_metre"
        if getattr(self, other) is not None:
            raise ParameterError(other, f"wrong unit for {self.channel}; it is measured in {wanted}")
        value = getattr(self, wanted)
        if value is None:
            raise ParameterError(wanted, f"missing; {self.channel} needs its unit as {wanted}")
        _number(wanted, value, 1.0, 1e12, "counts")

    @property
    def position_object(self) -> tuple[int, int] | None:
        """Index and sub-index of `object`; None where the profile says it."""
        match = _OBJECT.fullmatch(self.object or "")
        return None if match is None else (int(match[1], 16), int(match[2] or "0", 16))

    @property
    def wrap_range(self) -> int:
        """Counts after which the raw counter starts again."""
        return self.range if self.range is not None else int(2**self.bits)

    @property
    def scale(self) -> float:
        """Signed radians (wheel, joint) or metres (link) per count."""
        if self.counts_per_metre is not None:
            return self.sign / self.counts_per_metre
        assert self.counts_per_turn is not None  # checked by __post_init__
        return self.sign * 2.0 * math.pi / self.counts_per_turn


@dataclass(frozen=True, slots=True)
class Drive:
    """One CiA 402 drive that turns a wheel by target velocity (60FFh).

    Attributes:
        wheel: The wheel that the drive turns.
        node: CANopen node id.
        cob_id: COB-ID of the RPDO that carries 60FFh (32 bits, signed) [counts/s].
        sign: +1 or -1, so that a positive wheel speed rolls forward.
        counts_per_turn: Counts of the drive's velocity unit per turn of the wheel.
        start_bit: First bit of 60FFh in the RPDO; 16 where the control word 6040h stands before it.
        eds: Path of the EDS or DCF file of its node; None where there is none.
    """

    wheel: Channel
    node: int
    cob_id: int
    sign: int
    counts_per_turn: float
    start_bit: int = 0
    eds: str | None = None

    def __post_init__(self) -> None:
        if self.wheel not in WHEELS:
            raise ParameterError("wheel", f"{self.wheel!r} is no wheel; expected one of {', '.join(WHEELS)}")
        _number("node", self.node, 1, 127, "(node id)")
        _pdo_cob_id(self.cob_id)
        if self.sign not in {1, -1}:
            raise ParameterError("sign", f"{self.sign} is neither 1 nor -1")
        _number("counts_per_turn", self.counts_per_turn, 1.0, 1e12, "counts")
        _number("start_bit", self.start_bit, 0, 32, "(bit)")
        if self.start_bit % 8:
            raise ParameterError("start_bit", f"{self.start_bit}; expected a multiple of 8")


@dataclass(frozen=True, slots=True)
class Limits:
    """Limits of the robot's motion.

    Attributes:
        speed: Highest speed of any wheel over the floor [m/s].
        acceleration: Highest acceleration of any wheel over the floor [m/s^2].
    """

    speed: float = 0.5
    acceleration: float = 0.5

    def __post_init__(self) -> None:
        _number("speed", self.speed, 0.001, 20.0, "m/s")
        _number("acceleration", self.acceleration, 0.001, 50.0, "m/s^2")


@dataclass(frozen=True, slots=True)
class VehicleParameters:
    """A robot: one truck, or two on a linkage, with the devices on its bus.

    Attributes:
        name: Name that the owner gives the robot.
        trucks: The trucks by name: `a` leads; `b` follows, on a two-truck robot.
        linkage: The linkage between two trucks; None on a single differential drive.
        bus: Bit rate and SYNC period of the CAN bus.
        encoders: The encoders in the order of the file; each channel at most once.
        drives: The drives of the wheels; empty where the robot is only read.
        limits: Limits of speed and acceleration.
    """

    name: str
    trucks: dict[TruckName, Truck]
    linkage: Linkage | None
    bus: Bus
    encoders: tuple[Encoder, ...]
    drives: tuple[Drive, ...] = ()
    limits: Limits = Limits()

    def __post_init__(self) -> None:
        if "a" not in self.trucks:
            raise ParameterError("truck.a", "missing; the leading or only truck is called a")
        if ("b" in self.trucks) != (self.linkage is not None):
            raise ParameterError(
                "linkage", "a second truck and [linkage] belong together; one of them is missing"
            )
        self._check_encoders()
        self._check_drives()
        self._check_eds()

    def _check_encoders(self) -> None:
        channels = [encoder.channel for encoder in self.encoders]
        for channel in channels:
            if channels.count(channel) > 1:
                raise ParameterError("encoder", f"channel {channel} stands twice")
        for channel in self.expected_channels:
            if channel not in channels:
                raise ParameterError("encoder", f"channel {channel} is missing")
        for channel in channels:
            if channel not in self.expected_channels:
                raise ParameterError("encoder", f"channel {channel} needs truck b and [linkage]")
        for encoder in self.encoders:
            for other in self.encoders:
                same_bits = (
                    encoder is not other
                    and encoder.cob_id == other.cob_id
                    and encoder.start_bit <= other.start_bit < encoder.start_bit + encoder.bits
                )
                if same_bits:
                    raise ParameterError(
                        "encoder",
                        f"{encoder.channel} and {other.channel} share bits of PDO {encoder.cob_id:03X}h",
                    )

    def _check_drives(self) -> None:
        wheels = [drive.wheel for drive in self.drives]
        for wheel in wheels:
            if wheels.count(wheel) > 1:
                raise ParameterError("drive", f"wheel {wheel} stands twice")
            if wheel not in self.wheels:
                raise ParameterError("drive", f"wheel {wheel} needs truck b")

    def _check_eds(self) -> None:
        for device in self.devices:
            last = self.eds_files.get(device.node)
            if device.eds is not None and device.eds != last:
                raise ParameterError(
                    "eds", f"both {device.eds} and {last} for node {device.node}; expected one file"
                )

    @property
    def devices(self) -> tuple[Encoder | Drive, ...]:
        """The encoders, then the drives."""
        return (*self.encoders, *self.drives)

    @property
    def eds_files(self) -> dict[int, str]:
        """Paths of the EDS and DCF files by node id, of the nodes that have one."""
        return {device.node: device.eds for device in self.devices if device.eds is not None}

    @property
    def nodes(self) -> tuple[int, ...]:
        """Node ids of the encoders and drives, in order."""
        return tuple(sorted({device.node for device in self.devices}))

    @property
    def expected_channels(self) -> tuple[Channel, ...]:
        """The channels that such a robot has: two, or seven."""
        return CHANNELS if self.linkage is not None else CHANNELS[:2]

    @property
    def wheels(self) -> tuple[Channel, ...]:
        """The wheels in the order of `CHANNELS`: two, or four."""
        return WHEELS if self.linkage is not None else WHEELS[:2]

    @property
    def channels(self) -> tuple[Channel, ...]:
        """The encoders' channels in the order of the file."""
        return tuple(encoder.channel for encoder in self.encoders)

    def encoder(self, channel: Channel) -> Encoder:
        """Return the encoder of a channel; KeyError where the robot has none."""
        for encoder in self.encoders:
            if encoder.channel == channel:
                return encoder
        raise KeyError(channel)

    def drive(self, wheel: Channel) -> Drive:
        """Return the drive of a wheel; KeyError where the robot has none."""
        for drive in self.drives:
            if drive.wheel == wheel:
                return drive
        raise KeyError(wheel)

    def wheel_diameter(self, wheel: Channel) -> float:
        """Return a wheel's diameter [m]."""
        truck = self.trucks["a" if wheel.startswith("a") else "b"]
        return truck.wheel_diameter_left if wheel.endswith("left") else truck.wheel_diameter_right

    def metres_per_count(self, wheel: Channel) -> float:
        """Return the signed travel per count of a wheel [m], U (2.1) with c_m = pi D / counts_per_turn."""
        return self.encoder(wheel).scale * self.wheel_diameter(wheel) / 2.0

    def with_truck(self, name: TruckName, truck: Truck) -> VehicleParameters:
        """Return the same robot with another truck `name`."""
        return replace(self, trucks={**self.trucks, name: truck})
