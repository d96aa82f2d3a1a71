"""Changes of a URDF: what is not needed goes, treads become round, wheels and axles move, loads are added."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from collections.abc import Sequence

Place = tuple[float, float, float]  # [m]
ORIGIN: Place = (0.0, 0.0, 0.0)


def bare(text: str, rolling: Sequence[str]) -> str:
    """Return a URDF without what is only seen, and with the shapes of `rolling` alone, which touch the floor.

    Links without a mass get one of a gram: PyBullet would give them a kilogram. Contacts are hard: soft
    wheels sink into a height field and touch triangles beside them, which push them aside even at rest.
    """
    root = ET.fromstring(text)  # a file of an installed package
    for link in root.findall("link"):
        kept = link.attrib["name"] in rolling
        unused = ("visual", "contact") if kept else ("visual", "contact", "collision")
        for part in (part for name in unused for part in link.findall(name)):
            link.remove(part)
        if link.find("inertial") is None:
            link.append(ET.fromstring(inertial(1e-3, 1e-6)))  # as above
    return ET.tostring(root, encoding="unicode")


def with_tread(text: str, link: str, radius: float, off_axle: Place = ORIGIN) -> str:
    """Return a URDF with a spherical tread on a wheel, its centre off the middle of the tyre [m]."""
    root = ET.fromstring(text)  # made here
    collision = _named(root, "link", link).find("collision")
    assert collision is not None, f"{link} has no shape"
    origin, geometry = collision.find("origin"), collision.find("geometry")
    assert geometry is not None
    middle = ORIGIN if origin is None else _place(origin.attrib["xyz"])
    for part in list(collision):
        collision.remove(part)
    place = _words(*(a + b for a, b in zip(middle, off_axle, strict=True)))
    ET.SubElement(collision, "origin", xyz=place, rpy="0 0 0")
    ET.SubElement(ET.SubElement(collision, "geometry"), "sphere", radius=repr(radius))
    return ET.tostring(root, encoding="unicode")


def middle(text: str, link: str) -> Place:
    """Return the middle of a link's shape in its frame [m]."""
    root = ET.fromstring(text)  # made here
    origin = _named(root, "link", link).find("collision/origin")
    return ORIGIN if origin is None else _place(origin.attrib["xyz"])


def with_inertia(text: str, link: str, inertia: float) -> str:
    """Return a URDF with another moment of inertia of a link about each axis [kg m^2]."""
    root = ET.fromstring(text)  # made here
    known = _named(root, "link", link).find("inertial/inertia")
    assert known is not None, f"{link} has no inertia"
    for axis in ("ixx", "iyy", "izz"):
        known.set(axis, repr(inertia))
    return ET.tostring(root, encoding="unicode")


def with_soft(text: str, link: str, stiffness: float, damping: float) -> str:
    """Return a URDF with a soft contact of a link: its stiffness [N/m] and damping [N s/m]."""
    root = ET.fromstring(text)  # made here
    contact = ET.SubElement(_named(root, "link", link), "contact")
    ET.SubElement(contact, "stiffness", value=repr(stiffness))
    ET.SubElement(contact, "damping", value=repr(damping))
    return ET.tostring(root, encoding="unicode")


def with_moved(text: str, joint: str, by: Place, yaw: float = 0.0) -> str:
    """Return a URDF with a joint moved [m], then turned about its parent's vertical [rad]."""
    root = ET.fromstring(text)  # made here
    origin = _named(root, "joint", joint).find("origin")
    assert origin is not None, f"{joint} has no origin"
    x, y, z = (a + b for a, b in zip(_place(origin.attrib["xyz"]), by, strict=True))
    roll, pitch, heading = _place(origin.attrib.get("rpy", "0 0 0"))
    cosine, sine = math.cos(yaw), math.sin(yaw)
    origin.set("xyz", _words(cosine * x - sine * y, sine * x + cosine * y, z))
    origin.set("rpy", _words(roll, pitch, heading + yaw))
    return ET.tostring(root, encoding="unicode")


def with_links(text: str, *parts: str) -> str:
    """Return a URDF with more links and joints, each as XML."""
    return text.replace("</robot>", "".join(parts) + "</robot>")


def link(name: str, mass: float, inertia: float, shape: str = "", at: Place = ORIGIN) -> str:
    """Return a link as XML: mass [kg], inertia about each axis [kg m^2], shape as XML, centre of mass [m]."""
    touching = f"<collision><geometry>{shape}</geometry></collision>" if shape else ""
    return f'<link name="{name}">{inertial(mass, inertia, at)}{touching}</link>'


def joint(
    name: str,
    kind: str,
    ends: tuple[str, str],
    at: Place = ORIGIN,
    axis: Place = (0.0, 0.0, 1.0),
    damping: float = 0.0,
) -> str:
    """Return a joint as XML, from parent to child (`ends`), at a place in the parent [m].

    Its damping is in N s/m or N m s/rad.
    """
    parent, child = ends
    limit = '<limit lower="-1" upper="1" effort="1e4" velocity="1e2"/>' if kind == "prismatic" else ""
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{_words(*at)}" rpy="0 0 0"/><axis xyz="{_words(*axis)}"/>'
        f'<dynamics damping="{damping!r}" friction="0"/>{limit}</joint>'
    )


def sphere(radius: float) -> str:
    return f'<sphere radius="{radius!r}"/>'


def inertial(mass: float, inertia: float, at: Place = ORIGIN) -> str:
    """Return a mass [kg], its moment of inertia about each axis [kg m^2] and its place [m], as XML."""
    return (
        f'<inertial><origin xyz="{_words(*at)}" rpy="0 0 0"/><mass value="{mass!r}"/>'
        f'<inertia ixx="{inertia!r}" iyy="{inertia!r}" izz="{inertia!r}" ixy="0" ixz="0" iyz="0"/></inertial>'
    )


def _named(root: ET.Element, kind: str, name: str) -> ET.Element:
    element = next((candidate for candidate in root.findall(kind) if candidate.attrib["name"] == name), None)
    assert element is not None, f"no {kind} {name!r}"
    return element


def _place(words: str) -> Place:
    x, y, z = map(float, words.split())
    return x, y, z


def _words(*numbers: float) -> str:
    return " ".join(map(repr, map(float, numbers)))
