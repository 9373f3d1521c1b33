"""The left column of the studio's page: target, method and prediction, and the button that starts a run."""

from typing import TYPE_CHECKING, Any

from trame.widgets import html, vuetify3

from planner.target import TARGET_SUFFIXES
from scenes.studio.form import METHODS
from scenes.studio.workspace import CALIBRATION_SUFFIXES, LARGEST_UPLOAD_MB

if TYPE_CHECKING:
    from scenes.studio.session import BrowserSession

FIELD = {"density": "compact", "variant": "outlined", "hide_details": True, "persistent_placeholder": True}


def build_form(session: "BrowserSession") -> None:
    """Build the column in the present place of the page."""
    with html.Div(classes="column form"):
        _brand()
        _target_form(session)
        _method_form()
        _prediction_form()
        _start(session)


def _brand() -> None:
    with html.Div(classes="brand"):
        html.B("lce studio")
        html.Span("on this machine only", classes="quiet")


def _heading(number: int, text: str) -> None:
    with html.H2():
        html.Span(str(number), classes="number")
        html.Span(text)


def _text_field(name: str, label: str, **more: Any) -> None:
    vuetify3.VTextField(v_model=(name,), label=label, **FIELD, **more)


def _select(name: str, label: str, items: list[tuple[str, str]], **more: Any) -> None:
    choices = [{"title": title, "value": value} for value, title in items]
    vuetify3.VSelect(v_model=(name,), items=(f"{name}_items", choices), label=label, **FIELD, **more)


def _upload(kind: str, label: str, suffixes: tuple[str, ...], classes: str) -> None:
    """A form that sends itself as soon as a file is chosen; its answer goes into a frame that nobody sees."""
    with html.Form(
        action=f"upload?kind={kind}",
        method="post",
        enctype="multipart/form-data",
        target="upload_answer",
        classes="upload",
    ):
        html.Span(label, classes=classes)
        html.Input(
            type="file",
            name="file",
            accept=",".join(suffixes),
            __properties=["title", ("aria_label", "aria-label")],
            title=f"{' '.join(suffixes)}, up to {LARGEST_UPLOAD_MB} MB",
            aria_label=label,
            change="uploading = true; $event.target.form.requestSubmit(); $event.target.form.reset()",
        )


def _target_form(session: "BrowserSession") -> None:
    _heading(1, "Target")
    _upload("target", "Open a mesh, height map or point cloud", TARGET_SUFFIXES, "pick")
    html.Div("or a built-in scene:", classes="quiet my-2")
    vuetify3.VSelect(
        model_value=("scene",),
        update_modelValue=(session.choose_scene, "[$event]"),
        items=("scenes",),
        item_title="name",
        item_value="name",
        item_props=("(item) => ({subtitle: item.description})",),
        label="Scene",
        **FIELD,
    )
    with html.Div(v_if="upload_name", classes="opened"):
        vuetify3.VIcon("mdi-file-outline", size="small")
        html.Span("{{ upload_name }}")
    with html.Div(v_if="upload_name"):
        with html.Div(classes="fields"):
            _text_field("width_mm", "Width of the box [mm]", type="number", min="0", placeholder="as it is")
            _text_field("height_mm", "Height of the box [mm]", type="number", min="0", placeholder="as it is")
            axes = [(axis, axis) for axis in ("+z", "-z", "+y", "-y", "+x", "-x")]
            _select("up", "Axis that is up", axes, v_if="asks_up")
            _text_field("depth_mm", "Depth [mm]", type="number", min="0", v_if="asks_depth")
        html.Div(
            "The surface is scaled, evenly in x, y and z, to fit into the box. Empty: as it is, in mm.",
            classes="quiet mt-1",
        )
    html.Div("A built-in scene has its own size.", v_if="scene", classes="quiet mt-1")


def _method_form() -> None:
    _heading(2, "Method")
    for value, title, words in METHODS:
        with html.Label(classes=(f"['method', method === '{value}' ? 'chosen' : '']",)):
            html.Input(type="radio", name="method", value=value, v_model=("method",))
            html.B(title)
            html.Span(words, classes="quiet")
    with html.Div(v_if="method === 'inverse'", classes="fields"):
        _text_field("budget_s", "Time to search [s]", type="number", min="0", placeholder="until it pays no more")
        _select("stack", "Passes", [("", "each layer"), ("pairs", "in pairs")])
    with html.Label(v_if="method === 'inverse'", classes="row mt-2"):
        html.Input(type="checkbox", v_model=("robust",), style="accent-color: #17646b")
        html.Span("Design for films with errors of the process")
    with html.Details():
        html.Summary("More options")
        with html.Div(classes="fields"):
            _select(
                "tracer",
                "Passes laid",
                [("", "as usual"), ("greedy", "greedily"), ("dense", "densely")],
                v_if="method !== 'inverse'",
            )
            _select(
                "flattening",
                "Flattening",
                [("", "as usual"), ("arap", "as rigid as possible"), ("grid", "grid blocks")],
                v_if="method !== 'inverse'",
            )
            _text_field(
                "margin_mm", "Margin [mm]", type="number", min="0", placeholder="as usual", v_if="method !== 'inverse'"
            )
            _text_field("seed", "Seed", type="number", min="0", placeholder="as usual")
        _text_field("layers_mm", "Layers, bottom first [mm]", placeholder="0.2,0.2,0.2,0.2", classes="mt-2")
        with html.Div(classes="between mt-2"):
            html.Span(
                "Calibration: {{ calibration_name || 'a placeholder, not measured' }}", style="overflow-wrap: anywhere"
            )
            _upload("calibration", "Open", CALIBRATION_SUFFIXES, "pick small")
        html.Button(
            "Back to the placeholder",
            v_if="calibration_name",
            classes="link",
            click="calibration = ''; calibration_name = ''",
        )


def _prediction_form() -> None:
    _heading(3, "Prediction")
    with html.Div(classes="fields"):
        _text_field("temperature_c", "Heat to [C]", type="number", placeholder="150")
        _text_field("mesh_mm", "Mesh [mm]", type="number", min="0", step="0.1", placeholder="0.6")
        _select("support", "Film", [("", "on hot plate"), ("free", "weightless")])
        _text_field("modulus_mpa", "Modulus [MPa]", type="number", min="0", step="0.1", placeholder="0.5")


def _start(session: "BrowserSession") -> None:
    with html.Div(classes="start"):
        vuetify3.VBtn(
            "Plan and predict",
            click=session.start_run,
            disabled=("!target || opening || uploading",),
            color="primary",
            block=True,
            flat=True,
            classes="text-none",
        )
