"""The report in a browser: it opens offline, its pictures move, it prints, and it stays harmless.

All of it with a prediction whose name tries to run a script.
"""

import io
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from planner.plan import plan_summary
from planner.program import load_machine, load_program
from scenes.planning import plan_into
from scenes.prediction import predict_into
from scenes.report import ReportContents, write_report
from scenes.targets import two_bump
from twin.film import FilmOptions
from twin.hot_shape import HotShape
from twin.predict import PredictOptions
from twin.score import Score

HOSTILE = "</script><script>window.stolen = 1</script><img src=x onerror='window.stolen = 2'> & co"
COARSE = PredictOptions(film=FilmOptions(mesh_mm=1.5), device="cpu")
SECTIONS = (
    "Verdict",
    "Target and hot shape",
    "Error and depth images",
    "Plan",
    "Time budget of each layer",
    "Settings",
    "How to reproduce",
)
READY_MS = 60_000
UNPLANNED = {"clamped": None, "plan_notes": []}


@dataclass
class Opened:
    """A page with everything that it complained about or asked for."""

    page: object
    errors: list[str] = field(default_factory=list)
    requests: list[str] = field(default_factory=list)


def open_report(page, path, *, ready="#sheets[data-ready]"):
    opened = Opened(page=page)
    page.on("console", lambda said: opened.errors.append(said.text) if said.type == "error" else None)
    page.on("pageerror", lambda error: opened.errors.append(str(error)))
    page.on("request", lambda request: opened.requests.append(request.url))
    page.goto(path.as_uri())
    page.wait_for_selector(ready, state="attached", timeout=READY_MS)
    return opened


@dataclass(frozen=True, kw_only=True)
class Made:
    """A prediction with its folder."""

    folder: Path
    shape: HotShape
    result: dict


@pytest.fixture(scope="session")
def predicted(browser, tmp_path_factory):
    """A dome beside a hollow, small and coarse; the browser comes first, since nothing is made without one."""
    target = replace(two_bump(width_mm=20, height_mm=13, bump_mm=1.6, spread_mm=3), name=HOSTILE)
    folder = tmp_path_factory.mktemp("report")
    made = plan_into(folder, target)
    prediction = predict_into(folder, made.program, target, COARSE, plan_figures=plan_summary(made))
    return Made(folder=folder, shape=prediction.shape, result=prediction.result)


@pytest.fixture(scope="session")
def report(predicted):
    return predicted.folder / "report.html"


@pytest.fixture(scope="session")
def shared(browser, report):
    with browser.new_context(viewport={"width": 1280, "height": 900}) as context:
        yield open_report(context.new_page(), report)


@pytest.fixture
def opened(shared):
    """The report, opened once for all tests, each of which must leave it without an error."""
    yield shared
    assert shared.errors == []


@pytest.fixture
def page(opened):
    return opened.page


def picture(page, selector):
    return np.asarray(Image.open(io.BytesIO(page.locator(selector).screenshot())).convert("RGB"), dtype=float)


def difference(first, second):
    return np.abs(first - second).mean()


def slide(page, selector, value):
    page.locator(selector).evaluate("(e, v) => { e.value = v; e.dispatchEvent(new Event('input')) }", value)


def settled(page, selector, before):
    """Wait until a picture is another than before, and return it."""
    for _ in range(50):
        page.wait_for_timeout(100)
        now = picture(page, selector)
        if difference(now, before) > 0.02:
            return now
    pytest.fail(f"{selector} did not change")
    return None


def cameras(page):
    return page.evaluate("['target-3d', 'film-3d'].map((id) => document.getElementById(id).layout.scene.camera.eye)")


def test_it_opens_without_asking_for_anything(opened, report):
    assert [url for url in opened.requests if not url.startswith(("data:", "blob:"))] == [report.as_uri()]
    assert report.stat().st_size < 8e6
    assert [heading.inner_text() for heading in opened.page.locator("h2").all()] == list(SECTIONS)


def test_a_hostile_name_is_a_name(page):
    assert page.evaluate("window.stolen") is None
    assert page.locator("h1").inner_text().startswith(HOSTILE)
    assert page.evaluate("[...document.images].every((image) => image.src.startsWith('data:image/png'))")


def test_the_slider_heats_the_film_and_not_the_target(page):
    hot, target = picture(page, "#film-3d"), picture(page, "#target-3d")
    slide(page, "#temperature", 0)
    cold = settled(page, "#film-3d", hot)
    assert page.locator("#temperature-told").inner_text() == "25 °C, calculated"
    slide(page, "#temperature", 60)
    assert page.locator("#temperature-told").inner_text().startswith("85 °C, between ")
    slide(page, "#temperature", 125)
    again = settled(page, "#film-3d", cold)
    assert page.locator("#temperature-told").inner_text() == "150 °C, calculated"
    assert difference(again, hot) < 0.02 < difference(cold, hot)
    assert difference(picture(page, "#target-3d"), target) < 0.02


def test_the_film_can_be_coloured_by_its_error(page):
    plain, target = picture(page, "#film-3d"), picture(page, "#target-3d")
    page.check("input[name=colours][value=error]")
    red, _, blue = np.moveaxis(settled(page, "#film-3d", plain), 2, 0)
    assert (red - blue).max() > 60
    assert (blue - red).max() > 60
    assert difference(picture(page, "#target-3d"), target) < 0.02
    assert "distance from the target" in page.locator("#scale").inner_text()
    page.check("input[name=colours][value=plain]")
    page.wait_for_timeout(300)


def test_cameras_turn_together(page):
    before, film = cameras(page), picture(page, "#film-3d")
    assert before[0] == before[1]
    box = page.locator("#target-3d").bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + 90, y + 40, steps=4)
    page.mouse.up()
    turned = settled(page, "#film-3d", film)
    dragged = cameras(page)
    assert dragged[0] == pytest.approx(dragged[1])
    assert dragged != before
    page.focus("#film-3d")
    page.keyboard.press("ArrowLeft")
    settled(page, "#film-3d", turned)
    by_key = cameras(page)
    assert by_key[0] == pytest.approx(by_key[1])
    assert by_key != dragged
    page.click("[data-view=start]")
    page.wait_for_timeout(300)


def test_layers_are_switched_and_played(page):
    whole = picture(page, "#plan-canvas")
    assert page.locator("#told-side").inner_text() == "convex"
    page.select_option("#pace", "30")
    slide(page, "#clock", 60)
    started = settled(page, "#plan-canvas", whole)
    assert page.locator("#told-time").inner_text().startswith("1:00 of ")
    assert page.locator("#told-load").inner_text().endswith(" g")
    page.click("#play")
    played = settled(page, "#plan-canvas", started)
    assert page.locator("#play").inner_text() == "Pause"
    page.click("#play")
    assert page.locator("#play").inner_text() == "Play"
    page.check("input[name=layer][value='3']")
    assert difference(settled(page, "#plan-canvas", played), whole) > 0.02
    assert page.locator("#told-side").inner_text() == "concave"


def test_it_prints_whole(page):
    page.emulate_media(media="print")
    try:
        assert page.locator("canvas:visible").count() == 0
        assert page.locator("img:visible").count() == page.locator("img").count() == 5
    finally:
        page.emulate_media(media="screen")
    printed = page.pdf(format="A4", tagged=True, outline=True)
    assert printed.startswith(b"%PDF")
    for section in SECTIONS[1:]:  # the verdict needs no title
        assert f"/Title ({section})".encode() in printed, section


NO_WEBGL = """
const whole = HTMLCanvasElement.prototype.getContext;
HTMLCanvasElement.prototype.getContext = function (kind, ...more) {
  return kind.startsWith("webgl") ? null : whole.call(this, kind, ...more);
};
"""


@pytest.mark.parametrize(
    ("missing", "told"),
    [(NO_WEBGL, "has no WebGL"), ("delete window.DecompressionStream", "too old for the 3-D view")],
    ids=["webgl", "unpacking"],
)
def test_where_the_3d_view_cannot_be_shown_pictures_are(browser, report, missing, told):
    with browser.new_context() as context:
        context.add_init_script(missing)
        opened = open_report(context.new_page(), report, ready=f"#sheets-message:has-text('{told}')")
        page = opened.page
        assert page.locator("#sheets-message").is_visible()
        assert page.locator("#shape img").first.is_visible()
        assert not page.locator("#temperature").is_visible()
        assert page.locator("#plan-canvas").is_visible()
        assert opened.errors == []


def test_a_film_without_target_that_is_cooled_again(browser, predicted, tmp_path):
    """The same film, as if it had not been scored and its ramp had gone back."""
    shape, result = predicted.shape, predicted.result
    scores = Score.__dataclass_fields__
    cooled = replace(
        shape,
        temperature_c=np.append(shape.temperature_c, shape.temperature_c[0]),
        vertices_mm=np.concatenate([shape.vertices_mm, shape.vertices_mm[:1]]),
    )
    contents = ReportContents(
        result={key: value for key, value in result.items() if key not in scores} | UNPLANNED,
        program=load_program(predicted.folder),
        machine=load_machine(),
        shape=cooled,
        target=None,
        scored=None,
    )
    write_report(tmp_path, contents)
    with browser.new_context() as context:
        opened = open_report(context.new_page(), tmp_path / "report.html")
        page = opened.page
        assert "not scored" in page.locator("#verdict").inner_text()
        assert page.locator("#target-3d").count() == 0
        assert page.locator("#temperature-told").inner_text() == "150 °C, calculated"
        slide(page, "#temperature", 250)
        assert page.locator("#temperature-told").inner_text() == "25 °C, cooling, calculated"
        assert opened.errors == []
