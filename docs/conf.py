"""The documentation site: `make docs` builds it into out/docs, without the network."""

import sys
from importlib.metadata import version as installed_version
from pathlib import Path

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE / "extensions")]

project = "lce-twin"
author = "the authors of lce-twin"
version = release = installed_version("lce-twin")
language = "en"

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.napoleon",
    "sphinx_copybutton",
    "sphinx_gallery.gen_gallery",
    "api_pages",
    "help_texts",
    "mathml",
    "readme_links",
]
templates_path = ["templates"]
exclude_patterns = ["api/generated/*.md", "gallery/*.md5", "gallery/*.py", "gallery/*.ipynb", "gallery/*.zip"]
suppress_warnings = ["config.cache"]  # the gallery's settings hold a class and a function, which are not kept
show_warning_types = True
nitpicky = True
nitpick_ignore_regex = [
    ("py:obj", ".*"),  # words between backticks that name nothing stay plain
    # types of rooms whose inside is not documented
    ("py:class", r"rig\.(executor|virtual|dialects|pump_load|heating_watch|machine_sections)\..*"),
    ("py:class", r"(planner\.program\.(machine|toml_file)|planner\.calibration\.map_posterior)\..*"),
    ("py:class", r"twin\.(shell\.topology|equilibrium\.linear|batch\.together)\..*"),
    # other libraries are not linked: their inventories would be downloaded
    ("py:.*", r"(numpy|np|scipy|pathlib|pydantic|pydantic_core|annotated_types|warp|shapely|collections|types)\b.*"),
    ("py:.*", r"Path|FieldInfo|NoneType|tuple\[float"),
]

html_theme = "furo"
html_title = f"lce-twin {release}"
html_static_path = ["static"]
html_css_files = ["site.css"]
html_show_sphinx = False
html_show_copyright = False
html_copy_source = False
html_math_renderer = "mathml"
html_theme_options = {
    "light_css_variables": {"color-brand-primary": "#a8481f", "color-brand-content": "#a8481f"},
    "dark_css_variables": {"color-brand-primary": "#f0a27c", "color-brand-content": "#f0a27c"},
}
pygments_style = "friendly"

default_role = "py:obj"
highlight_language = "none"
myst_enable_extensions = ["dollarmath", "colon_fence"]
myst_heading_anchors = 3

autosummary_generate = True
autosummary_ignore_module_all = False
autodoc_default_options = {
    "members": True,
    "undoc-members": True,
    "member-order": "bysource",
    "exclude-members": "model_config, model_post_init, model_fields, model_computed_fields",
}
autodoc_preserve_defaults = True
autodoc_typehints_format = "short"
python_maximum_signature_line_length = 90
python_use_unqualified_type_names = True
napoleon_numpy_docstring = False
napoleon_use_rtype = False

copybutton_exclude = ".linenos, .gp, .go"

sphinx_gallery_conf = {
    "examples_dirs": [str(HERE.parent / "examples")],
    "gallery_dirs": ["gallery"],
    "within_subsection_order": "FileNameSortKey",
    # examples that take minutes end in _slow.py; `make docs-slow` runs them too, by another pattern
    "filename_pattern": r"(?<!_slow)\.py$",
    "image_scrapers": ("written_pictures.scrape",),
    "reset_modules": ("written_pictures.begin",),
    "download_all_examples": False,
    "show_memory": False,
    "show_signature": False,
    "remove_config_comments": True,
    "min_reported_time": 1,
    "write_computation_times": False,
    "abort_on_example_error": True,
    "plot_gallery": "True",
}
