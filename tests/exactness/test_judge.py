"""The judge accepts right answers and sees each kind of wrong one."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

import conicoid as co

from ..oracle.cases import Case
from .judge import Judge, Score
from .membership import body_at
from .oracle import Oracle
from .shapes import exact_shape

BALL = Case("Sphere", {"radius": 5.0, "center": (0.0, 0.0, 0.0)}, (0.0, 0.0, 0.0), 10.0)
PLANE = Case("Plane", {"normal": (0.0, 0.0, 1.0), "offset": 7.0}, (0.0, 0.0, 7.0), 10.0, False)
ORIGINS = np.array([[0.1, 0.2, -9.0], [4.9, 0.3, -9.0], [0.0, 5.0, -9.0], [1.0, 1.0, 1.0], [3.0, 4.0, 0.0]])
DIRECTIONS = np.array([[0.0, 0.1, 1.0], [0.0, 0.01, 2.0], [0.0, 0.0, 1.0], [0.3, 0.2, 0.5], [1.0, 0.0, 0.0]])


class Right:
    """A library that answers with the oracle, rounded; `spoil` changes its columns."""

    def __init__(self, oracle: Oracle, spoil=lambda columns: None) -> None:
        self.oracle, self.spoil = oracle, spoil

    def __getattr__(self, name):
        return getattr(co, name)

    def Scene(self, items):
        return self

    def crossings(self, o, d, t_min):
        a = self.oracle.answers(o, d)
        error = np.where(a.low == 0, 0.0, 2 * np.spacing(np.abs(a.high)))
        columns = dict(
            ray=a.ray,
            t=a.high.copy(),
            t_error=error,
            body=a.body.copy(),
            face=a.face.copy(),
            entering=a.entering.copy(),
        )
        self.spoil(columns)
        offsets = np.concatenate([[0], np.cumsum(np.bincount(columns["ray"], minlength=len(o)))])
        return SimpleNamespace(offsets=offsets, **columns)

    def first_hit(self, o, d):
        found = self.crossings(o, d, 0)
        rows = np.flatnonzero(found.t > 0)
        rays, first = np.unique(found.ray[rows], return_index=True)
        empty = dict(t=np.inf, t_error=0.0, body=-1, face=-1, entering=False)
        columns = {name: np.full(len(o), value) for name, value in empty.items()}
        for name, column in columns.items():
            column[rays] = getattr(found, name)[rows[first]]
        hit = np.isfinite(columns["t"])
        point = np.where(hit[:, None], o + np.where(hit, columns["t"], 0)[:, None] * d, np.nan)
        point_error = np.where(hit, 1e-14, np.nan)
        return SimpleNamespace(
            point=point, point_error=point_error, normal=point, local_point=point, uv=point, **columns
        )

    def occluded(self, o, d):
        return np.isfinite(self.first_hit(o, d).t)

    def spans(self, o, d, t_min):
        found = Right(self.oracle).crossings(o, d, t_min)
        ball = found.body == 0
        enter, leave = ball & found.entering, ball & ~found.entering
        return SimpleNamespace(
            offsets=np.concatenate([[0], np.cumsum(np.bincount(found.ray[enter], minlength=len(o)))]), body=found.body[enter],
            t_enter=found.t[enter], t_exit=found.t[leave], t_enter_error=found.t_error[enter], t_exit_error=found.t_error[leave],
            enter_clipped=np.zeros(enter.sum(), bool), exit_clipped=np.zeros(leave.sum(), bool),
        )  # fmt: skip

    def body_at(self, points):
        return body_at(self.oracle, points)


def judged(spoil=lambda columns: None) -> Score:
    oracle = Oracle(exact_shape(BALL, PLANE), (0, 0, 0), 10.0)
    return Judge(Right(oracle, spoil), oracle, [BALL, PLANE], ORIGINS, DIRECTIONS).run()


def test_right_answers_pass():
    score = judged()
    score.check()
    assert (score.rays, score.crossings) == (5, 12)
    assert score.slackness >= 1


def test_body_at_knows_points_on_the_surface():
    oracle = Oracle(exact_shape(BALL), (0, 0, 0), 10.0)
    points = np.array([[3.0, 4.0, 0.0], [np.nextafter(3, 9), 4.0, 0.0], [0.0, 0.0, 0.0], [9.0, 0.0, 0.0]])
    assert body_at(oracle, points).tolist() == [0, -1, 0, -1]


def changed(name, change):
    def spoil(columns):
        columns[name][0] = change(columns[name][0])

    return spoil


def without_first(columns):
    for name, column in columns.items():
        columns[name] = column[1:]


SPOILS = {
    "a missing crossing": (without_first, "count"),
    "three units in the last place": (changed("t", lambda t: t + 4 * np.spacing(t)), "t_error"),
    "a bound that is too small": (changed("t_error", lambda e: e * 1e-3), "t_error"),
    "inside out": (changed("entering", np.logical_not), "entering"),
    "another body": (changed("body", lambda b: b + 1), "body"),
    "another face": (changed("face", lambda f: f + 1), "face"),
    "NaN": (changed("t", lambda t: np.nan), "t is not finite"),
}


@pytest.mark.parametrize("what", SPOILS)
def test_wrong_answers_are_seen(what):
    spoil, complaint = SPOILS[what]
    assert complaint in judged(spoil).wrong
