"""Sphinx: the pages of this project as a static site. docs/build_site calls it, from the root of the checkout."""

import os
import re
from pathlib import Path

import diagrams
import messages
import theme
from docutils import nodes
from sphinx.util import logging
from sphinx.util.nodes import make_refnode

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
WORK = Path(os.environ["COPEPOD_SITE_WORK"])  # what Doxygen and protoc have written
_LOG = logging.getLogger(__name__)

project = "Copepod"
author = "the Copepod developers"
copyright = "2026, the Copepod developers"
release = version = re.search(r"^project\(copepod VERSION ([\d.]+)", (ROOT / "CMakeLists.txt").read_text(), re.M)[1]
language = "en"

# The checkout is the source: links between pages and files are those that a reader of the checkout follows.
root_doc = "README"
include_patterns = ["README.md", "CHANGELOG.md", "CONTRIBUTING.md", "SECURITY.md", "docs/**.md"]
exclude_patterns = [".*", "build*", "runs", "**/node_modules", "tests"]
extensions = ["myst_parser", "breathe", "sphinx.ext.autodoc"]

# The navigation; a page that is not in it is an error. Capitals: in the root of the checkout, else below docs/.
NAVIGATION = {
    "Use": "installing your_first_own_swimmer case_keys shapes flows steering controllers python paraview hosts "
    "recording",
    "Theory and results": "theory theory_fluid theory_bodies results/README",
    "Your own solver": "adding_a_component protocol site/messages moving_to_a_newer_kit foreign_engines",
    "Reference": "site/python_package site/python_kit site/cpp_kit",
    "Development": "architecture conventions how_a_key_travels site/decisions CONTRIBUTING SECURITY versions CHANGELOG",
}

# Folders that pages link to; all others are shown as text.
FOLDERS = {"docs/decisions": "docs/site/decisions", "proto/copepod/v1": "docs/site/messages"}

nitpicky = True
nitpick_ignore_regex = [
    # what the signatures of our own names mention: the compiler has checked them; others' libraries have no pages here
    (r"cpp:identifier", r".*"),
    (r"py:class", r"(pandas|xarray|numpy|collections|pathlib|enum)\..*|.*\.ComponentError|Any|Path"),
]
myst_heading_anchors = 6
default_role = "code"
pygments_style = "friendly"
pygments_dark_style = "monokai"
highlight_language = "none"

breathe_projects = {"kit": str(WORK / "doxygen/xml")}
breathe_default_project = "kit"
breathe_default_members = ("members", "undoc-members")
breathe_show_include = False
autodoc_default_options = {"members": True, "undoc-members": True, "show-inheritance": True}
autodoc_member_order = "bysource"
autodoc_typehints = "signature"
add_module_names = False

html_theme = "furo"
html_title = f"Copepod {release}"
html_static_path = ["site.css"]
html_css_files = ["site.css"]
html_copy_source = False
html_show_sphinx = False


def _with_contents(app, page, source):
    """The navigation below the front page, the results below theirs, and the messages on theirs."""
    if page == "README":
        for caption, names in NAVIGATION.items():
            pages = (name if name.isupper() else f"docs/{name}" for name in names.split())
            source[0] += _contents(f":caption: {caption}", *pages)
    elif page == "docs/results/README":
        source[0] += _contents(":glob:", "docs/results/*")
    elif page == "docs/site/messages":
        source[0] = source[0].replace("<!-- messages -->", "\n".join(messages.markdown(WORK / "messages.pb")))


def _contents(option, *pages):
    return "\n\n```{toctree}\n:hidden:\n" + "\n".join([option, "", *(f"/{page}" for page in pages)]) + "\n```\n"


def _with_diagrams(app, doctree):
    """Diagrams as pictures."""
    for block in list(doctree.findall(nodes.literal_block)):
        if block.get("language") == "mermaid":
            block.replace_self(nodes.raw("", diagrams.svg(block.astext()), format="html"))


def _folder(app, env, node, text):
    """Where a link to a folder of the checkout leads: its page, or nowhere."""
    target = (ROOT / env.doc2path(node["refdoc"], base=False)).parent / node.get("reftarget", "")
    if node.get("reftype") != "any" or not target.is_dir():
        return None
    page = FOLDERS.get(target.resolve().relative_to(ROOT).as_posix())
    return make_refnode(app.builder, node["refdoc"], page, None, text) if page else text


def _parameters(tag):
    return f":param {','.join(filter(None, tag.groups()))}: "


_TAGS = {
    r"@param (\w+)(?:, (\w+))?\s+": _parameters,
    r"@throws (\w+)\s*": r":raises \1: ",
    r"@returns?\s+": ":returns: ",
}


def _as_restructured_text(app, what, name, thing, options, lines):
    """Our docstrings use Doxygen's tags, and indent code; names without one are errors."""
    if not any(line.strip() for line in lines):
        _LOG.warning("%s is not documented (%s). Give it a docstring.", name, what)
    read, is_code = [], False
    for line in lines:
        is_blank, before = not line.strip(), read[-1] if read else ""
        if not is_code and line.startswith("    ") and not before.strip():
            read += [".. code-block:: python", ""]
            is_code = True
        elif is_code and not is_blank and not line.startswith("    "):
            is_code = False
        for tag, field in () if is_code else _TAGS.items():
            if re.match(tag, line):
                line = re.sub(tag, field, line)
                read += [""] if before.strip() and not before.startswith((":", " ")) else []
        read.append(line if is_code else line.replace("|", "\\|"))
    lines[:] = read + [""]


def _is_documented(app, domain, kind, content):
    """As for docstrings: attributes have none, but comments (`#:`)."""
    if domain == "py" and kind not in ("module", "class", "exception") and not content.astext().strip():
        name = content.parent[0]["fullname"]
        _LOG.warning("%s is not documented (%s). Give it a docstring, or a comment `#: …`.", name, kind)


def _with_breaks(app, page, template, context, doctree):
    """Names in text may break after a dot or slash, long ones after an underscore: columns of tables stay narrow."""
    if "body" in context:
        context["body"] = re.sub(r'(?<=<span class="pre">)[^<]{12,}', _breakable, context["body"])


def _breakable(name):
    text = re.sub(r"\w{20,}", lambda long: long[0].replace("_", "_<wbr>"), name[0])
    return re.sub(r"([./])(?=\w)", r"\1<wbr>", text)


def _complete_theme(app, problem):
    if not problem:
        theme.complete(Path(app.outdir) / "_static")


def setup(app):
    app.connect("source-read", _with_contents)
    app.connect("doctree-read", _with_diagrams)
    app.connect("missing-reference", _folder)
    app.connect("autodoc-process-docstring", _as_restructured_text)
    app.connect("object-description-transform", _is_documented)
    app.connect("html-page-context", _with_breaks)
    app.connect("build-finished", _complete_theme)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
