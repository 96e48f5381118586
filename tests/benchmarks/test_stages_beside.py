"""Stages of Box2D v3 and Box3D, and the common groups in which gsenv stands beside them."""

from __future__ import annotations

from collections import Counter
from itertools import chain
from pathlib import Path

import numpy as np
import pytest

from benchmarks import stages
from benchmarks.accuracy.engines.peers import STAGES as PEER_STAGES
from benchmarks.accuracy.engines.peers import WHOLE
from benchmarks.accuracy.suites import suite_of
from benchmarks.common.files import packed
from benchmarks.common.tables import Table
from benchmarks.heaps import Phase
from benchmarks.stages.beside import (
    COMMON,
    GROUPS,
    SURPLUS,
    beside_table,
    common_of_ours,
    common_of_theirs,
    parts_of_page,
    stage_table,
    sums,
)
from benchmarks.stages.peers import NOWHERE, PeerProfile, rounds_of, typical
from gsenv.scenes import stack

OUR_STAGES = (*stages.STAGES, stages.OTHER)
OURS = {stage: 0.1 * (k + 1) for k, stage in enumerate(OUR_STAGES)}
PARTS = [*(stage for stage in PEER_STAGES if stage != WHOLE), NOWHERE]
THEIRS = {stage: 0.01 * (k + 1) for k, stage in enumerate(PARTS)}
START = Phase("settling", 0, 60)


def peer(phase: str, setting: str) -> PeerProfile:
    return PeerProfile("stack of 50", phase, "Box2D v3", setting, THEIRS, 2.5)


def test_every_stage_is_in_one_group() -> None:
    assert Counter(chain(*GROUPS.values())) == Counter(PARTS)
    assert Counter(chain(*(ours for ours, _ in COMMON.values()))) == Counter(OUR_STAGES)
    assert Counter(chain(*(theirs for _, theirs in COMMON.values()))) == Counter(list(GROUPS))


def test_groups_add_up_to_the_step() -> None:
    assert sum(sums(THEIRS, GROUPS).values()) == pytest.approx(sum(THEIRS.values()))
    assert sum(common_of_theirs(THEIRS).values()) == pytest.approx(sum(THEIRS.values()))
    assert sum(common_of_ours(OURS).values()) == pytest.approx(sum(OURS.values()))
    assert common_of_theirs(THEIRS)["islands and sleep"] == THEIRS["sleepIslands"]


def test_stages_and_the_surplus_add_up_to_the_cpu_time() -> None:
    one = peer("settling", "4 substeps")
    assert sum(common_of_theirs(one.stages).values()) + one.surplus == pytest.approx(2.5)


def test_parts_of_a_step_add_up_to_it() -> None:
    rounds = np.random.default_rng(1).uniform(1e-6, 2e-6, (1, 4, len(PEER_STAGES)))
    whole = PEER_STAGES.index(WHOLE)
    rounds[..., whole] = rounds.sum(axis=-1)
    parts = typical(rounds)
    assert list(parts) == PARTS
    assert sum(parts.values()) == pytest.approx(rounds[..., whole].sum())


def test_a_round_that_was_interrupted_does_not_count() -> None:
    rounds = np.full((5, 3, len(PEER_STAGES)), 1e-6)
    rounds[..., PEER_STAGES.index(WHOLE)] = 25e-6
    steady = typical(rounds)
    rounds[2, 1, :] += 4e-3
    assert typical(rounds) == pytest.approx(steady)
    assert steady["collide"] == pytest.approx(3e-6)
    assert steady[NOWHERE] == pytest.approx(3 * (25e-6 - 1e-6 * (len(PEER_STAGES) - 1)))


def test_table_of_stages() -> None:
    shown = stage_table([peer("settling", "4 substeps"), peer("at rest", "4 substeps")])
    assert list(shown.header) == ["Box2D v3, 4 substeps", "stack of 50, settling", "stack of 50, at rest"]
    assert [row[0] for row in shown.rows] == [*GROUPS, "**sum**", "from outside"]
    assert shown.rows[-2][1] == f"**{sum(THEIRS.values()):.3f}**"
    assert shown.rows[-1][1:] == ["2.500", "2.500"]


def test_table_of_both_engines() -> None:
    shown = beside_table("here", OURS, [peer("settling", "4 substeps"), peer("settling", "4 substeps, scalar")])
    assert all(len(row) == len(shown.header) == 6 for row in shown.rows)
    assert [row[0] for row in shown.rows] == [*COMMON, SURPLUS, "**sum**", "ratio"]
    detection = common_of_theirs(THEIRS)["detection"]  # by the engine's own clock, whatever the time from outside
    assert shown.rows[0][2] == f"{detection:.3f}"
    surplus = 2.5 - sum(THEIRS.values())
    assert shown.rows[-3][1:4] == ["", f"{surplus:.3f}", f"{-surplus:.3f}"]
    ours, theirs = sum(OURS.values()), 2.5  # its CPU time
    assert shown.rows[-2][1:4] == [f"**{ours:.3f}**", f"**{theirs:.3f}**", f"**{ours - theirs:.3f}**"]
    assert shown.rows[-1][1:] == ["", f"{ours / theirs:.2f}", "", f"{ours / theirs:.2f}", ""]


def test_page_has_a_table_of_each_build_and_of_each_phase() -> None:
    phases, settings = ("settling", "at rest"), ("4 substeps", "4 substeps, scalar")
    theirs = [peer(phase, setting) for phase in phases for setting in settings]
    tables = [part for part in parts_of_page({("stack of 50", phase): OURS for phase in phases}, theirs)
              if isinstance(part, Table)]  # fmt: skip
    assert [table.header[0] for table in tables] == [
        "Box2D v3, 4 substeps", "Box2D v3, 4 substeps, scalar", "stack of 50, settling", "stack of 50, at rest",
    ]  # fmt: skip


def test_page_without_other_engines_is_text_and_one_table() -> None:
    profile = stages.Profile("stack of 50", "settling", OURS, 1.25)
    alone = {"dim": 2, "profiles": packed([profile])}
    assert [type(part) for part in stages.report(alone).parts] == [str, Table]
    beside = stages.report(alone | {"peers": packed([peer("settling", "4 substeps")])})
    assert list(beside.parts[:2]) == list(stages.report(alone).parts)
    assert len(beside.parts) == 6


def test_rounds_are_of_the_usual_settings() -> None:
    model = stack(2).compile()
    found = [rounds.setting for rounds in rounds_of(suite_of(2, {"Box2D v3": Path()}), model, START)]
    assert [setting.label for setting in found] == ["4 substeps", "4 substeps, scalar"]
    assert all(setting.values["substeps"] == 4 and "contact" not in setting.values for setting in found)
    assert len(rounds_of(suite_of(3, {"Box3D": Path()}), model, START)) == 1
    assert rounds_of(suite_of(2), model, START) == []
