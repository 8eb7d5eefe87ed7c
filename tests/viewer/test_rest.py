"""The picture at rest: samples add up to smooth edges and soft shadows."""

import numpy as np
import pytest

import conicoid as co

from .browser import NARROW, needs_browser, opened


@needs_browser
@pytest.mark.deep
def test_at_rest_edges_become_smooth_and_shadows_soft(browser, tmp_path):
    floor = co.Body(co.Disc((0, 0, -1), (0, 0, 1), 6), co.matte("#c03028"))
    scene = co.Scene(
        [co.Sphere(0.7), floor], [co.PointLight((0, 0, 5))], co.Camera((0, -6, 4), (0, 0, -0.5), field_of_view=40)
    )
    with opened(browser, scene, tmp_path, NARROW) as page:
        sharp = page.pixels()[..., 0]
        page.ask("(() => { conicoid.film.most = 8; conicoid.film.wake(); })()")
        page.ask("conicoid.film.settled(8)")
        many = "(() => Array.from(conicoid.film.read().values))()"
        smooth = np.array(page.ask(many)).reshape(*sharp.shape, 4)[::-1][..., 0]
        page.page.get_by_label("Softness of shadows").focus()
        page.page.keyboard.press("End")
        page.ask("conicoid.film.settled(8)")
        soft = np.array(page.ask(many)).reshape(*sharp.shape, 4)[::-1][..., 0]
        assert page.ask("conicoid.state.softness") == 0.1
        page.page.keyboard.press("Home")
        page.ask("conicoid.film.settled(8)")
        again = np.array(page.ask(many)).reshape(*sharp.shape, 4)[::-1][..., 0]
    edges = np.abs(np.diff(sharp, axis=1)) > 0.1
    assert np.abs(np.diff(smooth, axis=1))[edges].mean() < 0.8 * np.abs(np.diff(sharp, axis=1))[edges].mean()
    assert (np.abs(soft - smooth) > 0.05).mean() > 0.004  # the half-shadow
    assert np.array_equal(again, smooth)
