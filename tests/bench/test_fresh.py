"""Whole processes in fresh environments: what they find, what they must answer, and what is told of those that fail."""

from __future__ import annotations

import numpy as np
import pytest
from PIL import Image

from benchmarks.comparison import startup as fresh
from benchmarks.comparison.harness import Absent, Size
from benchmarks.comparison.startup import HITS, OURS, PICTURES

CACHED = """
import json, os, conicoid._util.environment
from importlib.util import cache_from_source
there = [os.path.exists(cache_from_source(each.__file__)) for each in (json, conicoid._util.environment)]
"""
BEFORE = f"import sys\nsys.dont_write_bytecode = True{CACHED}print(*there)"


def test_a_fresh_place_has_the_bytecode_of_the_standard_library_alone():
    with fresh.open_sandbox() as place:
        assert place.run(fresh._python(BEFORE))[1].split() == ["False", "False"]
        place.run(fresh._python(CACHED))
        assert place.run(fresh._python(BEFORE))[1].split() == ["True", "True"]
        with place.anew() as new:
            assert new.run(fresh._python(BEFORE))[1].split() == ["True", "False"]


def test_caches_of_the_user_are_not_found():
    program = "import os; print(os.listdir(os.path.expanduser('~')), os.environ['XDG_CACHE_HOME'])"
    with fresh.open_sandbox() as place:
        said = place.run(fresh._python(program))[1].split()
    assert said == ["[]", str(place.folder / "cache")]


@pytest.mark.deep
@pytest.mark.parametrize(("program", "check"), [(HITS[OURS], fresh.check_hit), (PICTURES[OURS], fresh.check_picture)])
def test_our_programs_answer_what_they_must(program, check):
    ours = fresh._python(program)
    found = fresh.compare_processes(ours, ours, check, cold=False)(Size(runs=1))
    assert found.apart == ""
    assert found.ratio == found.theirs / found.ours


def test_wrong_answers_are_told(tmp_path):
    assert fresh.check_hit("2.0\n", tmp_path) == ""
    assert fresh.check_hit("inf\n", tmp_path) == "the hit is at inf, not at 2"
    picture = np.zeros((48, 64), np.uint8)
    Image.fromarray(picture).save(tmp_path / "picture.png")
    assert fresh.check_picture("", tmp_path) == "the picture shows no ball"
    picture[10:38, 18:46] = 200
    Image.fromarray(picture).save(tmp_path / "picture.png")
    assert fresh.check_picture("", tmp_path) == ""
    Image.fromarray(picture[:40]).save(tmp_path / "picture.png")
    assert fresh.check_picture("", tmp_path) == "the picture has 40 x 64 pixels"


def test_a_program_that_fails_is_absent_with_its_last_words():
    with fresh.open_sandbox() as place, pytest.raises(Absent, match="ended with 1: ValueError: no such thing"):
        place.run(fresh._python("raise ValueError('no such thing')"))
