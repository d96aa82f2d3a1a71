"""What was learned as numbers and words for programs."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from omnimate.listen.dbc import dbc_start

if TYPE_CHECKING:
    from omnimate.listen.learning import Findings, LearnedMessage
    from omnimate.listen.meanings import Meaning


def findings_as_json(findings: Findings, meanings: dict[str, Meaning]) -> dict[str, Any]:
    """Return the findings as dictionaries and lists; times in seconds."""
    network = findings.network
    return {
        "frames": findings.frames,
        "seconds": findings.seconds,
        "sync": None
        if network.sync_period is None
        else {
            "period": network.sync_period,
            "jitter": network.sync_jitter,
            "overflow": network.sync_overflow,
        },
        "time_stamps": network.time_stamps,
        "nmt_commands": dict(network.commands),
        "nodes": [asdict(node) for node in network.nodes.values()],
        "messages": [_message(each, meanings) for each in findings.messages],
        "wheels": [
            {
                "signal": meanings[wheel.shaft.position.signal.label].name,
                "can_id": wheel.shaft.position.signal.can_id,
                "ratio": wheel.ratio,
                "ratio_spread": wheel.spread,
                "truck": wheel.truck,
                "side": wheel.side,
                "forward": wheel.forward or None,
            }
            for wheel in findings.kinematics.wheels
        ],
        "others": [
            {
                "signal": meanings[other.shaft.position.signal.label].name,
                "can_id": other.shaft.position.signal.can_id,
                "role": other.role,
                "explained": other.share,
            }
            for other in findings.kinematics.others
        ],
        "front_truck": findings.kinematics.front,
        "wheel_reasons": list(findings.kinematics.reasons),
        "turns": [turn - findings.start for turn in findings.kinematics.turns],
    }


def _message(each: LearnedMessage, meanings: dict[str, Meaning]) -> dict[str, Any]:
    message = each.message
    return {
        "can_id": message.can_id,
        "extended": message.is_extended,
        "node": message.node or None,
        "name": message.name,
        "length": message.data.shape[1],
        "frames": len(message.time),
        "sending": asdict(each.sending),
        "signals": [
            {
                "name": meanings[signal.label].name,
                "start_bit": dbc_start(signal),
                "bits": signal.bits,
                "byte_order": "big" if signal.is_big_endian else "little",
                "kind": signal.kind,
                "signed": signal.signed,
                "range": signal.turn or None,
                "multiplexor": signal.switch,
                "sure": signal.is_sure,
                "boundaries_probability": signal.boundaries,
                "kind_probability": signal.kind_probability,
                "meaning": meanings[signal.label].words,
                "reasons": list(signal.reasons),
            }
            for signal in each.signals
        ],
    }
