"""Names of components in sentences."""

from __future__ import annotations

_COMPONENTS = {
    "a": "truck a",
    "b": "truck b",
    "joint_a": "the encoder of joint a",
    "joint_b": "the encoder of joint b",
    "link": "the linear encoder of the link",
    "poses": "the measurement of absolute poses",
    "left": "both left wheels",
    "right": "both right wheels",
}


def component_in_words(component: str) -> str:
    """Return the name of a component in a sentence, such as "the left wheel of truck a"."""
    if "." in component:
        truck, side = component.split(".")
        return f"the {side} wheel of truck {truck}"
    return _COMPONENTS.get(component, component)
