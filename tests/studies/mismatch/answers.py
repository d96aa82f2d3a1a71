"""Labels, and answers of a tool about them, as the scoring reads both."""

import json


def effect(name="wheelbase", component="a", acceptable=(), **values):
    """Return an effect of a label; `acceptable` holds (effect, component) of what looks like it."""
    return {
        "effect": name, "component": component, "intervals": [],
        "parameters": {parameter: {"value": value, "unit": "1"} for parameter, value in values.items()},
        "acceptable": [{"effect": other, "component": place} for other, place in acceptable],
    }  # fmt: skip


def label(kind="single", *effects, **more):
    return {"kind": kind, "effects": list(effects), "recordings": ["1"], **more}


def finding(name="wheelbase", component="a", probability=0.95, alternatives=(), **values):
    """Return a finding; `alternatives` holds (effect, probability) of others on its component."""
    return {
        "effect": name, "component": component, "probability": probability, "where": {"intervals": []},
        "alternatives": [
            {"effect": other, "component": component, "probability": chance} for other, chance in alternatives
        ],
        "parameters": {
            parameter: {"value": value, "sigma": 1e-4, "unit": "1"} for parameter, value in values.items()
        },
    }  # fmt: skip


def answer(*findings, heldout=None):
    """Return an answer; `heldout` is the residual before and after what was found."""
    fit = heldout and {"heldout": dict(zip(("before", "after"), heldout, strict=True))}
    return {"verdict": "mismatch", "findings": list(findings), "fit": fit}


def write_healthy_set(folder, count):
    """Write the labels of a set of healthy robots."""
    folder.mkdir(parents=True)
    labels = {f"{folder.name}-{case}": label("null") for case in range(count)}
    (folder / "labels.json").write_text(json.dumps(labels))
