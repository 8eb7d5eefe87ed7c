"""Chains of edits: each scene has the tables of the scene from the beginning, in whatever memory they stand."""

from __future__ import annotations

import pytest

from conicoid.prepare.edits import in_place as exchange

from ..samples import in_turn, sampled
from .edits import KINDS, WORLDS, chain, note_memory_taken


@pytest.fixture
def taken(monkeypatch):
    """Whether each exchange takes memory that was another scene's."""
    return note_memory_taken(monkeypatch)


@pytest.mark.parametrize(("name", "seed"), in_turn(WORLDS, range(2)))
def test_a_chain_of_edits(name, seed, taken):
    merged = chain(name, seed, 14, 22)
    assert sum(taken) > 2 or name == "on a grid"
    assert merged > 2 or name == "of all kinds"


@pytest.mark.parametrize(("name", "seed"), sampled([(name, seed) for seed in range(2, 5) for name in KINDS], 4))
def test_a_chain_of_edits_beside_others(name, seed):
    """Floors, planes without an end, and many balls in one entry."""
    chain(name, seed, 14, 22)


@pytest.mark.parametrize("name", sampled(WORLDS[:4], 3))
def test_a_chain_of_edits_whose_tree_is_patched(name):
    chain(name, 7, 8, 280)


def test_a_chain_of_edits_that_write_all_rows(taken, monkeypatch):
    monkeypatch.setattr(exchange, "_MOST", 0)
    chain("of all kinds", 6, 14, 30)
    assert sum(taken) > 2


@pytest.mark.deep
@pytest.mark.parametrize("seed", range(10, 40))
@pytest.mark.parametrize("name", WORLDS)
def test_long_chains_of_edits(name, seed):
    chain(name, seed, 150, 20 + 90 * (seed % 4))
