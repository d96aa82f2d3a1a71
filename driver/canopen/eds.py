"""Reads EDS and DCF files with the errors that real ones have, and reports what had to be repaired."""

from __future__ import annotations

import configparser
import io
import re
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from canopen import import_od
from canopen.objectdictionary import ObjectDictionaryError

from omnimate.driver.errors import EdsError

if TYPE_CHECKING:
    from canopen import ObjectDictionary

_SECTION = re.compile(r"\[([^\]]*)\].*")
_OBJECT = re.compile(r"\[([0-9A-Fa-f]{4})(\w*)\]")
_SUBINDEX = re.compile(r"^([0-9A-F]{4})sub([0-9A-F]+)$", re.IGNORECASE)
_COMMENT = re.compile(r"\s+(?:#|//|;).*$")
_COMPACT, MAX_SUBINDEX = "CompactSubObj", 254  # number of the sub-indices, which have no sections
_DUMMIES = tuple(f"Dummy{number:04d}" for number in range(1, 8))
# Numbers without which canopen refuses the file, and their replacement; None: the line is left out.
_NUMBERS: dict[str, str | None] = {
    "DataType": "0x000F",  # DOMAIN: taken as bytes
    "ObjectType": None,
    _COMPACT: None,
    "PDOMapping": None,
    "NrOfEntries": "0",
    **dict.fromkeys(_DUMMIES, "0"),
    **{f"BaudRate_{rate}": None for rate in (10, 20, 50, 125, 250, 500, 800, 1000)},
    **dict.fromkeys(
        ("VendorNumber", "ProductNumber", "RevisionNumber", "SimpleBootUpMaster", "SimpleBootUpSlave",
         "Granularity", "DynamicChannelsSupported", "GroupMessaging", "NrOfRXPDO", "NrOfTXPDO",
         "LSS_Supported", "Baudrate", "NodeID")
    ),
}  # fmt: skip
# What canopen raises about a text that it cannot read.
_REFUSALS = (configparser.Error, ObjectDictionaryError, ValueError, LookupError, TypeError, AttributeError)
_VALUES = ("DefaultValue", "ParameterValue", "LowLimit", "HighLimit")  # numbers mostly, and often empty
_SECTIONS = {name.lower(): name for name in ("DeviceInfo", "DeviceComissioning", "DummyUsage")}
_KEYS = {key.lower(): key for key in (*_NUMBERS, *_VALUES, "ParameterName", "AccessType")}


@dataclass(frozen=True, slots=True)
class Eds:
    """A device description."""

    path: Path
    dictionary: ObjectDictionary  # object dictionary of the device, for one node id
    remarks: tuple[str, ...]  # what was changed to read the file, with line numbers


def load_eds(path: Path | str, node: int) -> Eds:
    """Return the object dictionary of an EDS or DCF file (CiA 306) for a node id, which replaces `$NODEID`.

    Raises EdsError where the file cannot be read even tolerantly.
    """
    path = Path(path)
    try:
        text, remarks = _decode(path.read_bytes())
        dictionary = _import(_expand(_repair(text, remarks)), node, remarks)
    except OSError as error:
        raise EdsError(str(path), f"cannot be read: {error.strerror or error}") from error
    except _REFUSALS as error:
        raise EdsError(str(path), f"not an EDS ({error}); expected the INI format of CiA 306") from error
    if not dictionary:
        raise EdsError(str(path), "no object in the file; expected sections such as [1000]")
    return Eds(path, dictionary, tuple(remarks))


def _import(text: str, node: int, remarks: list[str]) -> ObjectDictionary:
    """Return the dictionary of a repaired text, without the objects that canopen refuses."""
    try:
        return _import_whole(text, node)
    except _REFUSALS:
        head, objects = _by_object(text)
    accepted = [head]
    for index, sections in objects.items():
        try:
            _import_whole(head + sections, node)
        except _REFUSALS as error:
            remarks.append(f"[{index}]: left out: {error}")
        else:
            accepted.append(sections)
    return _import_whole("".join(accepted), node)


def _import_whole(text: str, node: int) -> ObjectDictionary:
    stream = io.StringIO(text)
    stream.name = "device.eds"  # canopen knows the format by the name
    return import_od(stream, node)


def _by_object(text: str) -> tuple[str, dict[str, str]]:
    """Return the sections that describe no object, and those of each object by its index as it is written.

    An object comes before its sub-indices, as canopen requires.
    """
    head, objects = "", dict[str, str]()
    for section in re.split(r"^(?=\[)", text, flags=re.MULTILINE):
        match = _OBJECT.match(section)
        if match is None:
            head += section
        elif match[2]:
            objects[match[1]] = objects.get(match[1], "") + section
        else:
            objects[match[1]] = section + objects.get(match[1], "")
    return head, objects


def _decode(data: bytes) -> tuple[str, list[str]]:
    try:
        return data.decode("utf-8-sig"), []
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        return data.decode("cp1252", "replace"), [f"line {line}: not UTF-8; read as Windows-1252"]


def _repair(text: str, remarks: list[str]) -> str:
    """Return the text so that `configparser` and canopen take it."""
    lines: list[str] = []
    sections: set[str] = set()
    keys: set[str] = set()
    skipping, section = True, ""
    for number, line in enumerate(text.splitlines(), start=1):
        stripped = line.strip()
        if match := _SECTION.fullmatch(stripped):
            lines += _dummies(section, keys, remarks)
            section = _SUBINDEX.sub(r"\1sub\2", match[1].strip())
            section, keys = _SECTIONS.get(section.lower(), section), set()
            skipping = section.lower() in sections
            sections.add(section.lower())
            if section.lower() == "comments":  # nobody reads them, and canopen refuses one that is missing
                skipping = True
            elif skipping:
                remarks.append(
                    f"line {number}: section [{section}] is given twice; the second one is ignored"
                )
            lines.append("" if skipping else f"[{section}]")
        elif skipping or not stripped or stripped[0] in ";#":
            lines.append("")
        else:
            lines.append(_entry(stripped, number, keys, remarks))
    lines += _dummies(section, keys, remarks)
    if "deviceinfo" not in sections:
        remarks.append("[DeviceInfo] missing; taken for empty")
        lines.append("[DeviceInfo]")
    return "\n".join([*lines, ""])


def _expand(text: str) -> str:
    """Return the text with a section for each sub-index of objects that state their number alone (CiA 306).

    canopen reads the first of them only, without values, and refuses names where not all are given.
    """
    if f"\n{_COMPACT}=" not in text:
        return text
    parser = configparser.RawConfigParser(inline_comment_prefixes=(";",))
    parser.optionxform = str  # type: ignore[assignment, method-assign]  # keys as they are
    parser.read_string(text)
    for index in [section for section in parser.sections() if parser.has_option(section, _COMPACT)]:
        described = dict(parser[index])
        count = min(int(described.pop(_COMPACT), 0), MAX_SUBINDEX)
        if not count:
            continue
        parser[index] = described
        names, values = (_listed(parser, f"{index}{kind}") for kind in ("Name", "Value"))
        members = [
            {"ParameterName": "NrOfObjects", "DataType": "5", "AccessType": "ro", "DefaultValue": str(count)}
        ]
        for key in map(str, range(1, count + 1)):
            name = {"ParameterName": names.get(key, f"{described.get('ParameterName', '')}{key}")}
            members.append(described | name | ({"ParameterValue": values[key]} if key in values else {}))
        for subindex, member in enumerate(members):
            if not parser.has_section(f"{index}sub{subindex:X}"):
                parser[f"{index}sub{subindex:X}"] = member
    written = io.StringIO()
    parser.write(written)
    return written.getvalue()


def _listed(parser: configparser.RawConfigParser, section: str) -> dict[str, str]:
    """Remove a section, and return what it lists by sub-index in decimal digits."""
    entries = dict(parser[section]) if parser.has_section(section) else {}
    parser.remove_section(section)
    return entries


def _entry(line: str, number: int, keys: set[str], remarks: list[str]) -> str:
    """Return a `key=value` line as canopen takes it, or an empty one."""
    key, equals, value = (part.strip() for part in line.partition("="))
    key = _KEYS.get(key.lower(), key)
    if not equals or not key:
        remarks.append(f"line {number}: {line!r} is no key=value; ignored")
        return ""
    if key in keys:
        remarks.append(f"line {number}: {key} is given twice in its section; the second one is ignored")
        return ""
    keys.add(key)
    bare = _number(_COMMENT.sub("", value))
    if key not in _NUMBERS and (bare is None or key not in _VALUES):
        return f"{key}={value}"
    if bare is None:
        bare = _NUMBERS[key]
        taken = "left out" if bare is None else f"taken for {bare}"
        remarks.append(f"line {number}: {key}={value!r} is no number; {taken}")
    elif bare != value and value.partition(";")[0].strip() != bare:
        remarks.append(f"line {number}: {key}={value!r} read as {bare}")
    return "" if bare is None else f"{key}={bare}"


def _number(text: str) -> str | None:
    """Return a number as Python writes it (CiA 306 allows leading zeros), None where it is none."""
    try:
        int(text, 0)
    except ValueError:
        return str(int(text)) if text.isascii() and text.isdigit() else None
    return text


def _dummies(section: str, keys: set[str], remarks: list[str]) -> list[str]:
    """Return the lines that a [DummyUsage] section lacks."""
    missing = [key for key in _DUMMIES if key not in keys] if section.lower() == "dummyusage" else []
    if missing:
        remarks.append(f"[{section}]: {', '.join(missing)} missing; taken for 0")
    return [f"{key}=0" for key in missing]
