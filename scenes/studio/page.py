"""The studio's page: the form on the left, what is shown in the middle, the runs on the right."""

from typing import TYPE_CHECKING, Any

from trame.ui.html import DivLayout
from trame.ui.vuetify3 import VAppLayout
from trame.widgets import client, html, vuetify3

from scenes.studio.page_form import build_form
from scenes.studio.style import STYLE

if TYPE_CHECKING:
    from scenes.studio.session import BrowserSession

SURFACES = "surfaces"
THEME = {
    "theme": {
        "defaultTheme": "studio",
        "themes": {"studio": {"dark": False, "colors": {"primary": "#17646b", "background": "#ffffff"}}},
    }
}


def build_page(session: "BrowserSession") -> None:
    """Build the page of a session."""
    surfaces_place(session.server).flush_content()
    with VAppLayout(session.server, vuetify_config=THEME):
        client.Style(STYLE)
        with html.Div(classes="studio"):
            build_form(session)
            with html.Div(classes="middle"):
                _problems()
                _welcome()
                _target_title()
                _run_head(session)
                _compare_head()
                _scene(session)
                _run_rest()
                _score_table()
            with html.Div(classes="column list"):
                _runs(session)
        html.Iframe(name="upload_answer", style="display: none")


def surfaces_place(server: Any) -> DivLayout:
    """Return the place of the surfaces, to be filled anew.

    It is a template of its own: when one changes, the browser makes all of it anew, and who types would lose the field.
    """
    return DivLayout(server, template_name=SURFACES, style="width: 100%; height: 100%")


def _problems() -> None:
    html.Div("{{ problem }}", v_for="problem in problems", key="problem", classes="wrong", role="alert")
    with html.Div(v_if="opening || uploading", classes="quiet row"):
        vuetify3.VProgressCircular(indeterminate=True, size="18", width="2", color="primary")
        html.Span("opening the target")


def _welcome() -> None:
    with html.Div(v_if="view === 'start' && !opening && !uploading", classes="welcome"):
        html.H1("See what a film will become", classes="title")
        html.P(
            "Plan how a flat film of liquid crystal elastomer is scratched, predict its shape when it is hot, and "
            "compare it with your target.",
            classes="mt-2",
        )
        with html.Ol(classes="mt-3"):
            html.Li("Open a target on the left: your own surface, or a built-in scene such as face.")
            html.Li("Choose a method. Perpendicular is a good first one.")
            html.Li("Press Plan and predict. The run goes on if you close this page, and its result stays.")
        html.P("Results are kept in {{ workspace }}", classes="quiet mt-3", style="overflow-wrap: anywhere")


def _target_title() -> None:
    with html.Div(v_if="view === 'target' && target"):
        html.H1("{{ target.name }}", classes="title")
        html.Div("{{ note }}", v_for="note in target.notes", key="note", classes="quiet")


def _run_head(session: "BrowserSession") -> None:
    with html.Div(v_if="view === 'run' && run"):
        with html.Div(classes="between"):
            html.H1("{{ run.title }}", classes="title")
            with html.Div(classes="row"):
                html.Span("{{ run.state }}", classes=("['state', run.state]",))
                vuetify3.VBtn(
                    "Cancel",
                    v_if="run.mine && (run.state === 'running' || run.state === 'queued')",
                    click=(session.cancel, "[run.id]"),
                    size="small",
                    variant="outlined",
                    classes="text-none",
                )
        html.Div("{{ run.options }}", v_if="run.options", classes="quiet")
        with html.Div(v_if="run.verdict", classes="mt-1"):
            html.Span("{{ run.verdict }}", classes="verdict")
            html.Span("{{ run.depth }}{{ run.depth ? '; ' : '' }}{{ run.paper }}", classes="quiet")
        html.Div("{{ problem }}", v_for="problem in run.problems", key="problem", classes="wrong", role="alert")
        with html.Div(v_if="run.state !== 'done'", classes="steps"):
            html.Span("{{ step.name }}", v_for="step in run.steps", key="step.name", classes=("step.state",))
        with html.Div(v_if="run.state === 'running'"):
            with html.Div(v_for="stage in run.stages", key="stage.name", classes="stage"):
                html.Span("{{ stage.name }}")
                with html.Div(classes="bar"):
                    html.Div(style=("{width: stage.percent + '%'}",))
                html.Span("{{ stage.percent }} %", classes="mono")
            html.Div("{{ run.note }}", v_if="run.note", classes="quiet")
        with html.Div(classes="files", v_if="run.files.length"):
            for name, label in (
                ("report.html", "Report"),
                ("program.json", "Program"),
                ("shape.ply", "Hot shape (.ply)"),
                ("result.json", "Numbers (.json)"),
            ):
                html.A(
                    label,
                    v_if=f"run.files.includes('{name}')",
                    href=(f"'runs/' + run.id + '/{name}'",),
                    classes="first" if name == "report.html" else "",
                    # Without leaving the page: browsers tell a page that is left so, and it would part with the studio.
                    **({"target": "_blank", "rel": "noopener"} if name == "report.html" else {"download": ""}),
                    __properties=["target", "rel", "download"],
                )
            for name, label in (("gcode.zip", "G-code preview (.zip)"), ("exports.zip", "All exports (.zip)")):
                html.A(
                    label,
                    v_if="run.files.includes('program.json')",
                    href=(f"'runs/' + run.id + '/{name}'",),
                    download="",
                    __properties=["download"],
                )


def _compare_head() -> None:
    with html.Div(v_if="view === 'compare'"):
        html.H1("Compare", classes="title")
        html.Div(
            "These runs have different targets: their scores do not compare.",
            v_if="!table.one_target",
            classes="warning",
        )


def _scene(session: "BrowserSession") -> None:
    with html.Div(v_show="captions.length", classes="scene"):
        with html.Div(classes="captions"), html.Div(v_for="(caption, place) in captions", key="place"):
            html.Div("{{ caption.title }}", style="font-weight: 500")
            html.Div("{{ caption.size }}", classes="quiet")
        with html.Div(style="position: absolute; inset: 0"):
            client.ServerTemplate(name=SURFACES)
        html.Div("drag: turn, wheel: zoom, shift and drag: move", classes="quiet hint")
        vuetify3.VBtn(
            icon="mdi-home-outline",
            size="small",
            variant="text",
            classes="home",
            click=session.turn_home,
            title="Look from where it began",
            __properties=["title"],
        )


def _run_rest() -> None:
    with html.Div(v_if="view === 'run' && run"):
        html.Div("{{ warning }}", v_for="warning in run.warnings", key="warning", classes="warning")
        with html.Details(v_if="run.files.includes('plan.png')"):
            html.Summary("Plan: what is scratched into each layer")
            html.Img(src=("'runs/' + run.id + '/plan.png'",), classes="picture", alt="The passes of each layer")
        html.Img(
            v_if="run.state === 'running' && run.files.includes('search.png')",
            src=("'runs/' + run.id + '/search.png?' + run.note",),
            classes="picture",
            alt="The present shape of the search",
        )
        with html.Details(v_if="run.log", open=("run.state === 'failed'",), __properties=["open"]):
            html.Summary("What the commands said")
            html.Div("{{ run.log }}", classes="log mono")


def _score_table() -> None:
    with html.Table(v_if="view === 'compare'", classes="scores"):
        with html.Thead(), html.Tr():
            html.Th("")
            with html.Th(v_for="each in table.runs", key="each.id"):
                html.Div("{{ each.title }}")
                html.Div("{{ each.options || each.created }}", classes="quiet", style="font-weight: 400")
        with html.Tbody(), html.Tr(v_for="row in table.rows", key="row.label"):
            html.Td("{{ row.label }}")
            html.Td("{{ value }}", v_for="(value, place) in row.values", key="place")


def _runs(session: "BrowserSession") -> None:
    with html.Div(classes="between mb-2"):
        html.H2("Runs", style="margin: 0")
        vuetify3.VBtn(
            "Compare {{ compared.length || '' }}",
            disabled=("compared.length < 2 || compared.length > most_compared",),
            click=session.compare,
            size="small",
            variant="outlined",
            color="primary",
            classes="text-none",
        )
    html.Div(
        "Tick two to {{ most_compared }} results to compare them.",
        v_if="runs.filter((each) => each.state === 'done').length > 1 && "
        "(compared.length < 2 || compared.length > most_compared)",
        classes="quiet mb-2",
    )
    html.Button(
        "Back to the target", v_if="target && view !== 'target'", classes="link mb-2", click=session.show_target
    )
    html.Div("None yet. Runs of all browsers appear here.", v_if="!runs.length", classes="quiet")
    with html.Div(
        v_for="each in runs",
        key="each.id",
        classes=("['card', each.id === selected ? 'chosen' : '']",),
        click=(session.select, "[each.id]"),
        keydown_enter=(session.select, "[each.id]"),
        __events=[("keydown_enter", "keydown.enter")],
        __properties=["tabindex", ("data_run", "data-run")],
        tabindex="0",
        data_run=("each.id",),
    ):
        with html.Div(classes="between"):
            html.Span("{{ each.title }}", classes="name")
            html.Span("{{ each.state }}", classes=("['state', each.state]",))
        html.Div("{{ each.options }}", v_if="each.options", classes="quiet")
        html.Div("{{ each.created }}{{ each.mine ? '' : ', another browser' }}", classes="quiet")
        with html.Div(v_if="each.state === 'running'"):
            html.Div("{{ each.doing }}", classes="quiet")
            with html.Div(classes="bar mt-1"):
                html.Div(style=("{width: each.percent + '%'}",))
        html.Div("{{ each.message }}", v_if="each.message", classes="quiet two-lines")
        with html.Div(v_if="each.state === 'done'", classes="between mt-1"):
            html.Span("{{ each.verdict }}", classes="verdict-line")
            with html.Label(classes="row quiet", click="$event.stopPropagation()"):
                html.Input(
                    type="checkbox",
                    checked=("compared.includes(each.id)",),
                    change=(session.toggle_compared, "[each.id]"),
                    __properties=["checked", ("aria_label", "aria-label")],
                    aria_label="compare this run",
                    style="accent-color: #17646b",
                )
                html.Span("compare")
