"""The derivatives of reflection and refraction, against differences in 40 digits of Snell's law in the plane."""

import mpmath
import numpy as np
import pytest

import conicoid as co
from conicoid.apps.derivatives import reflect_jvp, reflect_vjp, refract_jvp, refract_vjp

mp = mpmath.MPContext()
mp.dps = 40
STEP = mp.mpf(10) ** -15


def mirrored(d, n):
    n = n / mp.norm(n)
    return d - 2 * (d.T * n)[0] * n


def bent(d, n, eta):
    """Snell's law by angles: sin θ₂ = eta sin θ₁, in the plane of d and n."""
    size, n = mp.norm(d), n / mp.norm(n)
    u = d / size
    n = n if (u.T * n)[0] > 0 else -n
    angle = mp.acos((u.T * n)[0])
    sine = eta * mp.sin(angle)
    if sine > 1:
        return mirrored(d, n)
    aside = u - (u.T * n)[0] * n
    aside = aside / mp.norm(aside)
    beyond = mp.asin(sine)
    return size * (mp.cos(beyond) * n + mp.sin(beyond) * aside)


def column(values):
    return mp.matrix([mp.mpf(float(value)) for value in values])


@pytest.fixture(scope="module")
def some():
    random = np.random.default_rng(0)
    vectors = random.normal(size=(5, 60, 3))
    return *vectors, random.uniform(0.5, 1.9, 60), random.normal(size=60)


def test_reflection(some):
    d, n, dd, dn, w, _, _ = some
    found = reflect_jvp(d, n, dd, dn)
    for i in range(60):
        ends = [
            mirrored(column(d[i]) + s * STEP * column(dd[i]), column(n[i]) + s * STEP * column(dn[i])) for s in (1, -1)
        ]
        expected = [float(x) for x in (ends[0] - ends[1]) / (2 * STEP)]
        assert found[i] == pytest.approx(expected, rel=1e-12, abs=1e-12)
    of_d, of_n = reflect_vjp(d, n, w)
    assert (of_d * dd + of_n * dn).sum() == pytest.approx((w * found).sum(), rel=1e-12)


def test_refraction(some):
    d, n, dd, dn, w, eta, de = some
    found = refract_jvp(d, n, eta, dd, dn, de)
    _, total = co.refract(d, n, eta)
    assert 5 < total.sum() < 50
    for i in range(60):
        ends = [
            bent(column(d[i]) + s * STEP * column(dd[i]), column(n[i]) + s * STEP * column(dn[i]),
                 mp.mpf(eta[i]) + s * STEP * mp.mpf(de[i]))
            for s in (1, -1)
        ]  # fmt: skip
        expected = [float(x) for x in (ends[0] - ends[1]) / (2 * STEP)]
        assert found[i] == pytest.approx(expected, rel=1e-10, abs=1e-10)
    of_d, of_n, of_eta = refract_vjp(d, n, eta, w)
    assert (of_d * dd + of_n * dn).sum() + of_eta @ de == pytest.approx((w * found).sum(), rel=1e-12)


def test_what_broadcasts():
    assert refract_jvp((0, 0, -1), np.ones((4, 3)), 1.5, d_eta=1.0).shape == (4, 3)
    assert refract_vjp((0, 0, -1), np.ones((4, 3)), 1.5, (1, 0, 0))[2].shape == (4,)


def test_at_the_critical_angle_there_is_no_derivative():
    # sin θ = 0.6, eta = 5 / 3 in floats that make s exactly 0
    directions, eta = np.array([0.0, 0.0, -1.0]), 1.0
    found = refract_jvp(directions, (1, 0, 0), eta, d_eta=1.0)
    assert np.isnan(found).any()


def test_what_is_refused():
    with pytest.raises(ValueError, match=r"reflect_jvp: d_normals must broadcast to \(3,\), got \(2, 3\)"):
        reflect_jvp((0, 0, 1), (0, 0, 1), d_normals=np.zeros((2, 3)))
    with pytest.raises(ValueError, match=r"refract_vjp: cotangents must be an array of numbers"):
        refract_vjp((0, 0, 1), (0, 0, 1), 1.5, "x")
    with pytest.raises(ValueError, match="finite and not zero"):
        reflect_vjp((0, 0, 0), (0, 0, 1), (1, 0, 0))
