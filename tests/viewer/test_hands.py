"""Actions of a person on the page, with mouse, keys and fingers, by their effects on the screen."""

import io

import numpy as np
import pytest
from PIL import Image

import conicoid as co
from conicoid.viewer.playground import quadrics_scene
from conicoid.viewer.session import Session

from .browser import NARROW, WIDE, Page, needs_browser, open_exported, serve

pytestmark = needs_browser
CAMERA = co.Camera((0, -8, 0), (0, 0, 0), field_of_view=30)
LIGHTS = [co.AmbientLight(0.4), co.DirectionalLight((0.2, 1, -0.4), 0.6)]
RED, BLUE = co.matte("#c03028"), co.matte("#2848c0")
SCENE = co.Scene(
    [
        co.Body(co.Sphere(0.8, (-1, 0, 0)), RED, name="red ball"),
        co.Body(co.Box((0.4, -0.6, -0.6), (1.6, 0.6, 0.6)) - co.Sphere(0.4, (1, -0.6, 0)), BLUE, name="blue block"),
    ],
    lights=LIGHTS,
    camera=CAMERA,
)


@pytest.fixture(scope="module")
def shared_page(browser, tmp_path_factory):
    """Return one page for all tests that only look and select. Compiling its shader takes most of the time of a page."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("conicoid.viewer.html.read_engine", lambda: None)
        with open_exported(browser, SCENE, tmp_path_factory.mktemp("hands"), WIDE) as found:
            yield found


AS_OPENED = """(() => {
    document.activeElement.blur();
    conicoid.accept(JSON.parse(document.getElementById("conicoid-data").textContent).scene);
})()"""
"""The script shows the first scene again and clears all selections."""


@pytest.fixture
def page(shared_page):
    shared_page.ask(AS_OPENED)
    shared_page.settle()
    yield shared_page
    assert shared_page.errors == []


def test_a_page_forgets_the_selection(page):
    """Later tests on the same page rely on this."""
    page.page.mouse.move(*page.at(0.1, 0.9))
    before, panel = page.pixels(), page.text(".panel").partition(" samples")[2]
    page.drag(page.at(), page.at(0.9))
    page.page.locator("[data-item='0'] input[type=checkbox]").uncheck()
    page.page.locator("[data-item='1'] input[type=color]").fill("#00ff00")
    page.page.get_by_label("Cut the scene by a plane").check()
    page.page.mouse.click(*page.at(0.6))
    assert (page.pixels() != before).any()
    page.ask(AS_OPENED)
    assert (page.pixels() == before).all()
    assert page.text(".panel").partition(" samples")[2] == panel


@pytest.fixture
def engine_page(browser, tmp_path):
    path = tmp_path / "scene.yaml"
    co.save(SCENE, path)
    with serve(Session(co.load(path), "scene", path)) as server, Page(browser, server.url, WIDE) as found:
        found.path = path
        yield found


COLORS = """(() => {
    let behind = document.querySelector(".panel");
    const text = getComputedStyle(behind).color;
    while (getComputedStyle(behind).backgroundColor.endsWith(", 0)")) behind = behind.parentElement;
    return [text, getComputedStyle(behind).backgroundColor];
})()"""


def body_mask(pixels):
    return pixels[..., 3] > 0.5


def test_dragging_turns_the_scene(page):
    before = page.pixels()
    page.drag(page.at(), page.at(0.9))
    after = page.pixels()
    assert (body_mask(before) != body_mask(after)).mean() > 0.02
    # The page's picture is that of the engine from the page's new camera
    camera = page.ask("conicoid.state.camera")
    height, width = after.shape[:2]
    turned = co.Camera(camera["position"], camera["look_at"], camera["up"], camera["field_of_view"])
    assert np.linalg.norm(camera["position"]) == pytest.approx(8)
    assert (body_mask(after) == SCENE.occluded(turned.rays(width, height))).mean() >= 0.999


def test_keys_match_the_mouse(page):
    page.page.locator("canvas").focus()
    before = body_mask(page.pixels())
    for _ in range(4):
        page.page.keyboard.press("ArrowLeft")
    turned = body_mask(page.pixels())
    assert (turned != before).mean() > 0.01
    page.page.keyboard.press("+")
    assert body_mask(page.pixels()).sum() > turned.sum()
    page.page.keyboard.press("h")
    assert (body_mask(page.pixels()) == before).all()
    page.page.keyboard.press("3")  # from above
    assert page.ask("conicoid.state.camera.position[2]") > 2


def test_the_wheel_zooms_to_the_pointer(page):
    x, y = page.at(0.33, 0.5)
    before = page.ask("conicoid.firstAt({}, {})[0].body".format(*page.place(0.33, 0.5)))
    page.page.mouse.move(x, y)
    for _ in range(6):
        page.page.mouse.wheel(0, -120)
    after = page.pixels()
    assert page.ask("conicoid.firstAt({}, {})[0].body".format(*page.place(0.33, 0.5))) == before
    assert body_mask(after).mean() > 0.3


def test_fingers_turn_and_zoom(browser, tmp_path):
    with open_exported(browser, SCENE, tmp_path, NARROW, has_touch=True) as page:
        before = body_mask(page.pixels())
        fingers = """([kind, points]) => {
            for (const [id, x, y] of points) conicoid.canvas.dispatchEvent(new PointerEvent(kind, {
                pointerId: id, pointerType: "touch", clientX: x, clientY: y, bubbles: true, isPrimary: id === 1 }));
        }"""
        page.page.evaluate(fingers, ["pointerdown", [[1, 60, 60], [2, 100, 60]]])
        page.page.evaluate(fingers, ["pointermove", [[1, 40, 60], [2, 120, 60]]])
        page.page.evaluate(fingers, ["pointerup", [[1, 40, 60], [2, 120, 60]]])
        assert body_mask(page.pixels()).sum() > 1.5 * before.sum()


def test_hiding_isolating_and_tinting(page):
    before = page.pixels()
    page.page.locator("[data-item='0'] input[type=checkbox]").uncheck()
    hidden = page.pixels()
    width = before.shape[1]
    assert body_mask(before)[:, : width // 2].any()
    assert not body_mask(hidden)[:, : width // 2].any()
    assert np.array_equal(hidden[:, width // 2 :], before[:, width // 2 :])
    page.page.get_by_role("button", name="Show all").click()
    page.page.locator("[data-item='0'] button:has-text('Only')").click()
    assert not body_mask(page.pixels())[:, width // 2 :].any()
    page.page.get_by_role("button", name="Show all").click()
    page.page.locator("[data-item='0'] input[type=color]").fill("#00ff00")
    green = page.pixels()[:, : width // 2][body_mask(before)[:, : width // 2]]
    assert (green[:, 1] > 5 * green[:, 0]).mean() > 0.9


def test_the_section_plane_cuts_and_is_dragged(page):
    page.page.get_by_label("Cut the scene by a plane").check()
    page.page.get_by_role("button", name="x", exact=True).click()
    before = page.pixels()
    width = before.shape[1]
    assert not body_mask(before)[:, width // 2 + 12 :].any()  # x > 0 is cut away
    handle = page.page.locator(".handle").bounding_box()
    start = handle["x"] + handle["width"] / 2, handle["y"] + handle["height"] / 2
    page.drag(start, (start[0] + 60, start[1]))
    after = page.pixels()
    assert body_mask(after).sum() > body_mask(before).sum()
    assert page.ask("conicoid.state.section.offset") > 0.3
    page.page.get_by_role("button", name="flip").click()
    assert not body_mask(page.pixels())[:, : width // 4].any()
    # Towards the eye the plane shows the section, flat and in the body's own color
    page.page.get_by_role("button", name="y", exact=True).click()
    picture = page.pixels()[..., :3]
    height, width = picture.shape[:2]
    column = round(width / 2 - height / 2 / (8 * np.tan(np.radians(15))))  # of the ball's middle, x = -1
    ball = picture[height // 2 - 3 : height // 2 + 3, column - 3 : column + 3]
    assert ball.std(axis=(0, 1)).max() < 1e-3
    assert ball[..., 0].mean() > 3 * ball[..., 2].mean()


def test_a_click_without_a_server_is_answered_by_the_shader(page):
    page.page.mouse.click(*page.at(0.33))
    page.page.wait_for_selector(".found:not([hidden]) table.hit")
    text = page.text(".found")
    assert "red ball" in text
    assert "Computed by the shader, in single precision." in text
    hit = SCENE.first_hit(*page.ray(0.33, 0.5))
    assert page.ask("conicoid.state.found.t") == pytest.approx(hit.t, rel=1e-5)


def test_a_click_is_answered_by_the_engine_if_present(engine_page):
    engine_page.page.mouse.click(*engine_page.at(0.33))
    engine_page.page.wait_for_selector(".found:not([hidden]) table.hit")
    ray = engine_page.ray(0.33, 0.5)
    hit, spans = SCENE.first_hit(*ray), SCENE.spans(*ray)
    text = engine_page.text(".found")
    assert "Computed by the exact engine." in text
    for number in (hit.t, *hit.point, *hit.normal, *spans.t_enter, *spans.t_exit):
        assert engine_page.ask(f"String({float(number)!r})") in text


def test_measuring_between_two_clicks(engine_page):
    engine_page.page.get_by_label("Measure between two clicks").check()
    for x in (0.33, 0.62):
        engine_page.page.mouse.click(*engine_page.at(x, 0.45))
        engine_page.page.wait_for_timeout(400)
    rays = [engine_page.ray(x, 0.45) for x in (0.33, 0.62)]
    a, b = (SCENE.first_hit(*ray).point for ray in rays)
    shown = float(engine_page.text(".distance").split()[1])
    assert shown == pytest.approx(np.linalg.norm(a - b), rel=1e-6)


def test_x_rays_are_chords(page):
    page.page.get_by_label("X-ray").check()
    pixels = page.pixels()
    height, width = pixels.shape[:2]
    chords = SCENE.spans(CAMERA.rays(width, height)).line_integral(np.ones(2)).reshape(height, width)
    scale = page.ask("2.5 / conicoid.state.diagonal")
    assert np.abs(pixels[..., 0] - np.exp(-scale * chords)).max() < 2e-3


def test_sliders_change_the_body_and_keep_the_camera(engine_page):
    engine_page.drag(engine_page.at(), engine_page.at(0.55))
    before, camera = body_mask(engine_page.pixels()), engine_page.ask("conicoid.state.camera.position")
    engine_page.page.locator("[data-item='0'] button:has-text('Edit')").click()
    engine_page.page.get_by_label("radius, as a number").fill("0.4")
    engine_page.page.get_by_label("radius, as a number").press("Enter")
    engine_page.wait("conicoid.scene.bounds[0][0] > -1.5")
    after = body_mask(engine_page.pixels())
    assert 0 < after.sum() < 0.9 * before.sum()
    assert engine_page.ask("conicoid.state.camera.position") == camera


def test_the_file_is_followed_and_its_mistakes_are_shown(engine_page):
    before = body_mask(engine_page.pixels())
    text = engine_page.path.read_text()
    engine_page.path.write_text(text.replace("Sphere", "Spere"))
    engine_page.page.wait_for_selector(".trouble:not([hidden]):has-text('Spere')")  # not of a half-written file
    assert "line" in engine_page.text(".trouble") or ":" in engine_page.text(".trouble")
    assert (body_mask(engine_page.pixels()) == before).all()
    co.save(co.Scene([co.Body(co.Sphere(0.3), RED)], lights=LIGHTS, camera=CAMERA), engine_page.path)
    engine_page.page.wait_for_selector(".trouble", state="hidden")
    assert 0 < body_mask(engine_page.pixels()).sum() < 0.5 * before.sum()


def test_a_picture_is_saved(page):
    shown = page.pixels()
    with page.page.expect_download() as waiting:
        page.page.get_by_role("button", name="Save PNG").click()
    with open(waiting.value.path(), "rb") as file:
        saved = np.asarray(Image.open(io.BytesIO(file.read())).convert("RGB"), dtype=float) / 255
    assert waiting.value.suggested_filename == "scene.png"
    assert saved.shape[:2] == shown.shape[:2]
    linear = np.where(saved <= 0.04045, saved / 12.92, ((saved + 0.055) / 1.055) ** 2.4)
    assert (np.abs(linear - np.clip(shown[..., :3], 0, 1)) < 0.02).mean() > 0.95


def test_the_camera_is_copied_as_a_scene_file_has_it(browser, tmp_path):
    with open_exported(browser, SCENE, tmp_path, WIDE) as page:
        page.context.grant_permissions(["clipboard-read", "clipboard-write"])
        page.page.get_by_role("button", name="Copy camera").click()
        page.page.wait_for_selector(".toast:not([hidden])")
        text = page.ask("navigator.clipboard.readText()")
        (tmp_path / "again.yaml").write_text(f"conicoid: 1\n{text}\nbodies:\n  - shape: {{Sphere: {{}}}}\n")
        assert co.load(tmp_path / "again.yaml").camera == CAMERA


SEEN = """() => {
    const quality = document.querySelector('.quality');
    window.seen = [];
    const told = () => seen.push([quality.textContent, conicoid.film.shown.width]);
    new MutationObserver(told).observe(quality, {childList: true, characterData: true, subtree: true});
}"""


def test_resolution_drops_in_motion_and_recovers(page):
    """Software is slower than 30 pictures a second by far, so that the resolution must drop here.

    The test records the messages as they come, because on a busy machine the picture may be at rest when it looks.
    """
    page.ask(SEEN)
    mouse = page.page.mouse
    mouse.move(*page.at())
    mouse.down()
    for k in range(40):
        mouse.move(page.at()[0] + 3 * k, page.at()[1])
        page.page.wait_for_timeout(30)
    full = page.size()[0]
    widths = [width for text, width in page.ask("seen") if "while moving" in text]
    assert min(widths) < 0.9 * full
    mouse.up()
    page.settle()
    assert page.ask("conicoid.film.shown.width") == full


def test_everything_is_named_and_reachable(page):
    """Each control has a name for screen readers, and the tabulator reaches it."""
    unnamed = """[...document.querySelectorAll("button, input, canvas")].filter((e) => e.offsetParent !== null
        && !(e.getAttribute("aria-label") || e.textContent.trim() || e.labels?.length)).length"""
    assert page.ask(unnamed) == 0
    reached = set()
    for _ in range(40):
        page.page.keyboard.press("Tab")
        reached.add(
            page.ask(
                "document.activeElement.textContent.trim() || document.activeElement.ariaLabel || document.activeElement.name"
            )
        )
    assert {"Fit", "Save PNG", "Only", "Show red ball"} <= reached


def test_keys_on_the_panel_keep_their_place(page):
    page.page.locator("[data-item='1'] input[type=checkbox]").focus()
    before = body_mask(page.pixels())
    page.page.keyboard.press("Space")
    assert body_mask(page.pixels()).sum() < before.sum()
    assert page.ask("document.activeElement.ariaLabel") == "Show blue block"
    page.page.keyboard.press("Space")
    assert (body_mask(page.pixels()) == before).all()


def test_the_playground_of_quadrics_is_played_with(browser):
    """A cross term that is zero at first bends the ellipsoid."""
    with (
        serve(Session(quadrics_scene(), "Nine quadrics", select=0)) as server,
        Page(browser, server.url, WIDE) as page,
    ):
        page.page.wait_for_selector(".sliders .number")
        before = page.pixels()
        page.page.get_by_label("xy", exact=True).focus()
        for _ in range(6):
            page.page.keyboard.press("PageUp")
        page.wait("Number(document.querySelector('[aria-label=\"xy, as a number\"]').value) > 0.2")
        page.page.wait_for_timeout(600)
        after = page.pixels()
        assert (np.abs(after - before).max(axis=-1) > 0.05).mean() > 0.002
        assert page.errors == []


@pytest.mark.parametrize("scheme", ["dark", "light"])
def test_a_phone_shows_it_all_without_sideways_scrolling(browser, tmp_path, scheme):
    with open_exported(browser, SCENE, tmp_path, {"width": 400, "height": 700}, color_scheme=scheme) as page:
        assert page.ask("document.documentElement.scrollWidth") <= 400
        for name in ("Front", "Right", "Top", "Back", "Left", "Bottom", "Fit", "Home", "Panel"):
            box = page.page.get_by_role("button", name=name, exact=True).bounding_box()
            assert box["x"] >= 0
            assert box["x"] + box["width"] <= 400
            assert box["height"] >= 24  # the target size of WCAG 2.2
        assert 2 * page.size()[0] >= 380  # at half a pixel each
        colors = page.ask(COLORS)
        assert contrast(*colors) > 7


def contrast(*colors):
    """Return the contrast of WCAG 2."""
    levels = []
    for color in colors:
        rgb = np.array([float(v) for v in color.split("(")[1].rstrip(")").split(",")[:3]]) / 255
        linear = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
        levels.append(linear @ (0.2126, 0.7152, 0.0722) + 0.05)
    return max(levels) / min(levels)
