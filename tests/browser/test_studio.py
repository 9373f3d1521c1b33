"""The studio in a real browser: the whole way through the page, two browsers at once, and who is refused."""

import asyncio
import io
import json
import re
import shutil
import signal
import subprocess
import sys
import time
import zipfile
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import urlsplit

import numpy as np
import pytest

from planner.program import load_program

pytest.importorskip("trame", reason="the extra `studio` is absent: pip install '.[dev]'")
aiohttp = pytest.importorskip("aiohttp")

PATIENCE_MS, JOB_PATIENCE_MS = 30_000, 120_000
COMMAND = [sys.executable, "-m", "scenes.cli", "studio", "--no-browser", "--workspace"]
VIEW = {"width": 1280, "height": 800}


@dataclass(frozen=True, kw_only=True)
class Studio:
    """A running studio."""

    process: subprocess.Popen[str]
    url: str
    workspace: Path

    @property
    def port(self) -> int:
        return urlsplit(self.url).port or 0

    @property
    def token(self) -> str:
        return self.url.partition("token=")[2]

    def close(self) -> str:
        """End it as Ctrl-C does; returns what else it said."""
        self.process.send_signal(signal.SIGINT)
        said, _ = self.process.communicate(timeout=30)
        assert self.process.returncode == 0
        return said


def open_studio(workspace: Path) -> Studio:
    process = subprocess.Popen([*COMMAND, str(workspace)], stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    found = re.search(r"http://127\.0\.0\.1:\d+/\?token=\S+", process.stdout.readline())
    assert found is not None
    return Studio(process=process, url=found.group(), workspace=workspace)


@pytest.fixture(scope="module")
def studio(browser, tmp_path_factory) -> Iterator[Studio]:
    """A studio for all of these tests, that ends well."""
    running = open_studio(tmp_path_factory.mktemp("studio"))
    yield running
    if running.process.poll() is None:
        running.close()


@pytest.fixture(scope="module")
def context(browser):
    """The browser of one user, with its cookies."""
    with browser.new_context(viewport=VIEW, accept_downloads=True) as opened:
        opened.set_default_timeout(PATIENCE_MS)
        yield opened


@pytest.fixture(scope="module")
def dome(tmp_path_factory) -> Path:
    """A dome, 8 mm wide, as a height map."""
    x_mm = np.linspace(-4.0, 4.0, 41)
    distance = np.hypot(*np.meshgrid(x_mm, x_mm))
    z_mm = np.where(distance <= 4.0, 1.5 * np.sqrt(np.clip(1.1 - (distance / 4.0) ** 2, 0.0, None)), np.nan)
    path = tmp_path_factory.mktemp("dome") / "small dome.npz"
    np.savez(path, x_mm=x_mm, y_mm=x_mm, z_mm=z_mm)
    return path


def open_page(context, studio: Studio):
    page = context.new_page()
    page.goto(studio.url)
    page.get_by_role("button", name="Plan and predict").wait_for()
    return page


def open_target(page, path: Path) -> None:
    page.locator("form[action='upload?kind=target'] input").set_input_files(path)


def card(page, words: str):
    return page.locator(".card").filter(has_text=words)


def job_folder(studio: Studio, number: int) -> Path:
    asked = {path: json.loads(path.read_text()) for path in studio.workspace.glob("jobs/*/request.json")}
    return next(path.parent for path, request in asked.items() if request["number"] == number)


@pytest.fixture(scope="module")
def finished(studio, context, dome):
    """A page opened anew on a run that went on while no page was open; with what browsers complained of on the way."""
    complaints: list[str] = []
    context.on(
        "console",
        lambda message: complaints.append(f"{message.text} {message.location}") if message.type == "error" else None,
    )
    context.on("weberror", lambda found: complaints.append(str(found.error)))
    context.on("requestfailed", lambda request: complaints.append(f"{request.url} failed"))
    page = open_page(context, studio)
    open_target(page, dome)
    page.locator(".scene").get_by_text("7.8 x 7.8 mm, 1.0 mm deep").wait_for()
    page.get_by_label("Mesh [mm]").fill("1.2")
    page.get_by_role("button", name="Plan and predict").click()
    page.locator(".steps .running").get_by_text("Plan").wait_for()
    page.close()
    page = open_page(context, studio)
    card(page, "1: small_dome, perpendicular").get_by_text("done").wait_for(timeout=JOB_PATIENCE_MS)
    card(page, "1: small_dome").click()
    page.get_by_text("Predicted at 150 C").wait_for()
    return page, complaints


def test_the_page_shows_the_result_and_complains_of_nothing(finished):
    page, complaints = finished
    assert re.match(r"SSIM \d+\.\d %, RMS \d\.\d\d mm", page.locator("span.verdict").inner_text())
    page.locator(".warning", has_text="is a placeholder: loads and speeds are not measured").wait_for()
    assert complaints == []


def test_target_and_shape_are_drawn_side_by_side_and_turn_together(finished):
    page, _ = finished
    canvas = page.locator(".scene canvas")
    canvas.wait_for()

    def drawn() -> bool:
        """Both are there, and neither is drawn in black or bleached."""
        halves = [(half, half[half.min(axis=2) < 250]) for half in left_and_right(pixels(canvas.screenshot()))]
        return all(0.05 < len(seen) / half[..., 0].size < 0.8 and 60 < np.median(seen) < 240 for half, seen in halves)

    until(page, drawn)
    before = pixels(canvas.screenshot()).astype(int)
    box = canvas.bounding_box()
    start = box["x"] + box["width"] / 4, box["y"] + box["height"] / 2
    page.mouse.move(*start)
    page.mouse.down()
    page.mouse.move(start[0] + 60, start[1] + 40, steps=6)
    page.mouse.up()

    def turned() -> bool:
        changed = np.abs(pixels(canvas.screenshot()) - before).max(axis=2) > 8
        return all(half.mean() > 0.02 for half in left_and_right(changed))

    until(page, turned)


def until(page, condition: Callable[[], bool]) -> None:
    """Wait until something on a page holds."""
    ends = time.monotonic() + PATIENCE_MS / 1000
    while not condition():
        assert time.monotonic() < ends, "it never happened"
        page.wait_for_timeout(200)


def left_and_right(image: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    middle = image.shape[1] // 2
    return image[:, :middle], image[:, middle:]


def pixels(png: bytes) -> np.ndarray:
    from PIL import Image

    return np.asarray(Image.open(io.BytesIO(png)).convert("RGB"))


def test_program_report_and_gcode_preview_are_exported(finished, tmp_path):
    page, _ = finished
    got = {}
    for label in ("Program", "G-code preview (.zip)", "All exports (.zip)"):
        with page.expect_download() as download:
            page.get_by_text(label, exact=True).click()
        got[label] = tmp_path / download.value.suggested_filename
        download.value.save_as(got[label])
    program = load_program(got["Program"])
    assert program.name == "small_dome"
    with zipfile.ZipFile(got["G-code preview (.zip)"]) as archive:
        assert archive.namelist() == [f"layer_{number}.gcode" for number in (1, 2, 3, 4)]
    with zipfile.ZipFile(got["All exports (.zip)"]) as archive:
        assert {"layer_1.svg", "layer_1.dxf", "shape.stl", "result.csv"} <= set(archive.namelist())
    with page.context.expect_page() as opened:
        page.get_by_text("Report", exact=True).click()
    report = opened.value
    report.get_by_text("SSIM").first.wait_for()
    # A report's scripts have no way to the studio that serves it.
    assert report.evaluate("window.origin") == "null"
    assert report.evaluate("fetch('/').then(() => 'reached', () => 'kept out')") == "kept out"
    report.close()


def test_two_browsers_at_once_do_not_mix(finished, studio, browser):
    mine, _ = finished
    with browser.new_context(viewport=VIEW) as other_context:
        other_context.set_default_timeout(PATIENCE_MS)
        other = open_page(other_context, studio)
        other.get_by_text("Open a target on the left").wait_for()
        other.locator(".v-select").first.click()
        other.get_by_text("face", exact=True).click()
        other.get_by_text("Inverse", exact=True).click()
        mine.get_by_text("Maximum", exact=True).click()
        other.locator(".scene").get_by_text("Target").wait_for()
        # the first browser still shows its run, and its own form
        assert mine.locator("h1", has_text="1: small_dome").is_visible()
        assert mine.locator(".method.chosen b").inner_text().strip() == "Maximum"
        assert other.locator(".method.chosen b").inner_text().strip() == "Inverse"
        assert mine.locator(".opened").inner_text().strip() == "small_dome.npz"
        assert other.locator(".opened").count() == 0
        other.get_by_role("button", name="Plan and predict").click()
        other.locator(".stage").first.wait_for()
        seen = card(mine, "2: face, inverse")
        seen.get_by_text("running").wait_for()
        assert "another browser" in seen.inner_text()
        seen.click()
        mine.locator("h1", has_text="2: face").wait_for()
        assert mine.get_by_role("button", name="Cancel").count() == 0
        # a cancelled job leaves nothing half-written
        other.get_by_role("button", name="Cancel").click()
        card(other, "2: face, inverse").get_by_text("cancelled").wait_for()
        left = {path.name for path in job_folder(studio, 2).iterdir()}
        assert left == {"request.json", "state.json", "log.txt", "progress.jsonl"}
        seen.get_by_text("cancelled").wait_for()


@pytest.mark.parametrize(
    ("name", "content", "sentence"),
    [
        ("notes.txt", b"words", r"'notes.txt' ends in '.txt', allowed are"),
        ("broken.stl", b"solid nothing", r"broken\.stl"),
        ("empty.obj", b"", r"empty\.obj is empty \(0 bytes\)"),
    ],
)
def test_a_file_that_is_no_target_is_told_in_a_sentence(studio, page, tmp_path, name, content, sentence):
    (tmp_path / name).write_bytes(content)
    page.goto(studio.url)
    open_target(page, tmp_path / name)
    wrong = page.locator(".wrong").filter(has_text=re.compile(sentence))
    wrong.wait_for()
    told = wrong.inner_text()
    assert str(studio.workspace) not in told
    assert page.get_by_role("button", name="Plan and predict").is_disabled()


def apart(work):
    """Run a coroutine in a thread of its own: the browser's driver holds this one's event loop."""
    with ThreadPoolExecutor(1) as thread:
        return thread.submit(asyncio.run, work).result()


def entered(studio: Studio) -> dict[str, str]:
    """What a browser sends that was let in."""

    async def enter() -> dict[str, str]:
        async with aiohttp.ClientSession() as session, session.get(studio.url) as answer:
            assert answer.status == 200
            return {name: cookie.value for name, cookie in answer.cookies.items()}

    cookies = apart(enter())
    origin = f"http://127.0.0.1:{studio.port}"
    return {"Cookie": "; ".join(f"{name}={value}" for name, value in cookies.items()), "Origin": origin}


def without_token(headers: dict[str, str]) -> dict[str, str]:
    kept = [part for part in headers["Cookie"].split("; ") if part.startswith("lce_studio_browser=")]
    return {**headers, "Cookie": "; ".join(kept)}


def with_wrong_token(headers: dict[str, str]) -> dict[str, str]:
    # Another first character, whatever the token starts with.
    return {
        **headers,
        "Cookie": re.sub(
            r"(lce_studio_\d+=)(.)", lambda found: found[1] + ("x" if found[2] == "_" else "_"), headers["Cookie"]
        ),
    }


REFUSED: dict[str, Callable[[dict[str, str]], dict[str, str]]] = {
    "other origin": lambda headers: {**headers, "Origin": "http://evil.example"},
    "other port": lambda headers: {**headers, "Origin": "http://127.0.0.1:1"},
    "other host": lambda headers: {**headers, "Host": "evil.example"},
    "missing token": without_token,
    "wrong token": with_wrong_token,
    "no cookie": lambda headers: {"Origin": headers["Origin"]},
}


async def status_of(studio: Studio, method: str, path: str, headers: dict[str, str]) -> int:
    """Return the answer's status; a WebSocket that opens is 101."""
    url = f"http://127.0.0.1:{studio.port}{path}"
    async with aiohttp.ClientSession() as session:
        if method == "WS":
            try:
                async with session.ws_connect(url, headers=headers):
                    return 101
            except aiohttp.WSServerHandshakeError as error:
                return error.status
        async with session.request(method, url, headers=headers, allow_redirects=False) as answer:
            return answer.status


@pytest.mark.parametrize("who", REFUSED)
def test_others_are_refused(studio, who):
    right = entered(studio)
    wrong = REFUSED[who](right)
    for method, path in (
        ("GET", "/"),
        ("GET", "/index.html"),
        ("POST", "/paraview/"),
        ("POST", "/upload"),
        ("WS", "/ws"),
    ):
        assert apart(status_of(studio, method, path, wrong)) == 403, path
    # Browsers ask for the icon by themselves, and complain in their console where there is none.
    for path, status in (("/", 200), ("/index.html", 200), ("/favicon.ico", 200)):
        assert apart(status_of(studio, "GET", path, right)) == status
    assert apart(status_of(studio, "WS", "/ws", right)) == 101


def test_a_wrong_or_another_starts_token_in_the_address_is_refused(studio):
    for token in ("", "wrong", studio.token[:-1], studio.token + "x"):
        assert apart(status_of(studio, "GET", f"/?token={token}", {})) == 403
    assert apart(status_of(studio, "GET", "/", {})) == 403


def test_a_file_that_is_too_large_is_refused_and_not_kept(studio):
    before = set((studio.workspace / "uploads").iterdir())

    async def send() -> tuple[int, str]:
        form = aiohttp.FormData()
        form.add_field("file", io.BytesIO(bytes(65 << 20)), filename="large.stl")
        url = f"http://127.0.0.1:{studio.port}/upload"
        async with aiohttp.ClientSession() as session, session.post(url, data=form, headers=headers) as answer:
            return answer.status, await answer.text()

    headers = entered(studio)
    status, told = apart(send())
    assert (status, "larger than 64 MB" in told) == (400, True)
    assert set((studio.workspace / "uploads").iterdir()) == before


def test_only_files_of_jobs_are_served(studio, finished):
    headers = entered(studio)
    job = job_folder(studio, 1).name
    for path in (
        f"/runs/{job}/log.txt",
        f"/runs/{job}/..%2frequest.json",
        "/runs/../request.json",
        "/runs/x/report.html",
    ):
        assert apart(status_of(studio, "GET", path, headers)) == 404, path
    assert apart(status_of(studio, "GET", f"/runs/{job}/program.json", headers)) == 200


@pytest.fixture(scope="module")
def again(finished, studio) -> Iterator[Studio]:
    """The studio closed and opened anew, with a second result beside the first."""
    assert studio.close().splitlines()[-1] == "studio closed"
    first = job_folder(studio, 1)
    second = first.with_name("20260101-000000-0123abcd")
    shutil.copytree(first, second)
    for name, change in (("request.json", {"number": 9}), ("hot/result.json", {"ssim_eq4": 0.987})):
        content = json.loads((second / name).read_text())
        (second / name).write_text(json.dumps({**content, **change}))
    running = open_studio(studio.workspace)
    yield running
    running.close()


def test_a_studio_opened_anew_has_the_results_and_knows_its_browsers(again, studio, context, page):
    assert again.token != studio.token
    mine = open_page(context, again)
    card(mine, "1: small_dome").click()
    mine.get_by_text("Predicted at 150 C").wait_for()
    assert "another browser" not in card(mine, "1: small_dome").inner_text()
    page.goto(again.url)
    assert "another browser" in card(page, "1: small_dome").inner_text()


def test_two_results_are_compared(again, page):
    page.goto(again.url)
    for number in (1, 9):
        card(page, f"{number}: small_dome").get_by_label("compare this run").check()
    page.get_by_role("button", name="Compare 2").click()
    table = page.locator("table.scores")
    table.wait_for()
    heads = table.locator("thead th").all_inner_texts()
    assert [head.partition(":")[0] for head in heads[1:]] == ["1", "9"]
    written = [json.loads((job_folder(again, number) / "hot/result.json").read_text()) for number in (1, 9)]
    row = table.locator("tr", has_text="Eq. 4 of the paper").locator("td").all_inner_texts()
    assert row[1:] == [f"{result['ssim_eq4']:.3f}" for result in written]
    assert row[1] != row[2]
    page.locator(".captions").get_by_text("9: small_dome").wait_for()
    captions = page.locator(".captions > div").all_inner_texts()
    assert [caption.partition(":")[0][:6] for caption in captions] == ["Target", "1", "9"]


def test_fields_keep_what_is_typed_while_the_target_is_drawn_anew(again, page, dome):
    page.goto(again.url)
    open_target(page, dome)
    page.locator(".scene").get_by_text("7.8 x 7.8 mm").wait_for()
    width = page.get_by_label("Width of the box [mm]")
    width.press_sequentially("20")
    page.get_by_label("Height of the box [mm]").press_sequentially("20")
    page.locator(".scene").get_by_text("20.0 x 20.0 mm").wait_for()
    page.keyboard.type("0")
    assert page.get_by_label("Height of the box [mm]").input_value() == "200"
