"""Write the page: data, pictures, style and scripts, laid into its template."""

from importlib.resources import files
from pathlib import Path
from typing import Any

from scenes.report.contents import ReportContents
from scenes.report.facts import clamped_rows, material_rows, origin_rows, score_rows, solver_rows
from scenes.report.library import packed_plotly
from scenes.report.reproduce import plan_command, predict_command
from scenes.report.security import content_policy, script_hash
from scenes.report.sheets import pack_sheets
from scenes.report.stills import read_stills
from scenes.report.strokes import pack_strokes
from scenes.report.time_budget import time_bars
from scenes.report.verdict import duration, make_verdict

REPORT_FILE = "report.html"
SCRIPTS = ("unpack.js", "sheets.js", "plan.js")


def write_report(folder: Path, contents: ReportContents) -> Path:
    """Write report.html into `folder`, with the pictures that already lie there, and return its path.

    What is absent is left out: the target, the score, the clamped share, pictures.
    """
    path = folder / REPORT_FILE
    path.write_text(render_report(contents, folder), encoding="utf-8")
    return path


def render_report(contents: ReportContents, pictures: Path) -> str:
    """Return the page; it shows those pictures that lie in the folder `pictures`."""
    from jinja2 import Environment, PackageLoader, StrictUndefined
    from markupsafe import Markup

    environment = Environment(
        loader=PackageLoader("scenes.report", "page"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["duration"] = duration
    page = files("scenes.report") / "page"
    # Only the project's own files go into the page as they are; everything else is escaped.
    scripts = [Markup((page / name).read_text(encoding="utf-8")) for name in SCRIPTS]
    library = packed_plotly()
    return environment.get_template("report.html.jinja").render(
        policy=content_policy([*map(script_hash, scripts), library.hash]),
        style=Markup((page / "style.css").read_text(encoding="utf-8")),
        scripts=scripts,
        library=library.gzip_base64,
        **_told(contents, pictures),
    )


def _told(contents: ReportContents, pictures: Path) -> dict[str, Any]:
    """Return everything that the template says about this prediction."""
    result, program = contents.result, contents.program
    return {
        "result": result,
        "verdict": make_verdict(result),
        "stills": read_stills(pictures),
        "sheets": pack_sheets(contents),
        "strokes": pack_strokes(program, contents.machine),
        "bars": time_bars(result),
        "tables": {
            "scores": score_rows(result),
            "clamped": clamped_rows(result),
            "material": material_rows(result),
            "solver": solver_rows(result),
            "origin": origin_rows(result),
        },
        "commands": {
            "plan": plan_command(result, program, contents.source),
            "predict": predict_command(result, program, contents.source),
        },
    }
