"""Pushes of trucks: what they do, where they are looked for, and how they are told."""

import math

import numpy as np
import pytest

from omnimate.mismatch import diagnose
from omnimate.mismatch.candidates.pushes import ORDINARY_PUSH, PUSH_PART, PUSH_REGIME, Push, push
from omnimate.mismatch.evidence.search import overlap
from omnimate.mismatch.recording.signals import WINDOW, signals_of
from omnimate.mismatch.scans.events import push_terms

BEGIN = 40.0
LEANT_ON = Push("a", BEGIN, 2.0, ((0.0, 4e-3, 2e-3), (0.0, 8e-3, 2e-3)))


def test_a_push_displaces_its_truck_by_its_parts_and_no_other_truck(drive):
    block = signals_of(drive()).block
    after, _ = LEANT_ON.act(block)
    gained = after.twist - block.twist
    assert gained[:, 0].sum(axis=0) == pytest.approx([0.0, 12e-3, 4e-3], rel=0.03)
    assert not gained[:, 1].any()
    late = block.time > BEGIN + 1.0 + block.period.max()
    assert gained[late, 0].sum(axis=0) == pytest.approx(LEANT_ON.moved[1], rel=0.03)
    outside = (block.time < BEGIN) | (block.time > BEGIN + 2.0 + block.period.max())
    assert not gained[outside].any()


def test_a_candidate_has_three_columns_for_each_part_and_is_built_of_them():
    term = push("b", BEGIN, 100, 4 * PUSH_PART)
    assert len(term.probes) == 12
    built = term.built(np.arange(12.0))
    assert built.moved[1] == pytest.approx((3 * 3e-3, 4 * 3e-3, 5 * 1e-2))
    assert term.stretches == [(BEGIN, BEGIN + 4 * PUSH_PART)]


def test_what_is_ordinary_of_a_push_is_shared_by_its_parts():
    assert push("a", BEGIN, 100).nuisance_size == ORDINARY_PUSH
    assert push("a", BEGIN, 100, 4 * PUSH_PART).nuisance_size == pytest.approx(ORDINARY_PUSH / 2.0)


def test_a_push_of_seconds_is_a_candidate_from_its_begin_to_its_end(drive, regression, alone):
    model = regression(drive(LEANT_ON))
    offered = push_terms(model, [model.push_scores(alone(model).residual)])
    lasting = [term.stretches[0] for term in offered if term.fixed["lasting"] > WINDOW]
    assert any(
        math.isclose(begin, BEGIN, abs_tol=2 * WINDOW) and math.isclose(end, BEGIN + 2.0, abs_tol=2 * WINDOW)
        for begin, end in lasting
    )


def test_a_truck_that_is_pushed_for_seconds_is_told_as_unknown_with_the_time(drive):
    answer = diagnose([drive(LEANT_ON)])
    (finding,) = answer.findings  # encoders and the fixes at stops alone
    assert (finding.effect, finding.component, finding.where.regime) == ("unknown", "a", PUSH_REGIME)
    assert overlap(finding.where.intervals, [(BEGIN, BEGIN + 2.0)])
