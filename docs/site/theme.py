"""What Debian's package of the theme Furo (2022.12) leaves out, added to the files of a finished site.

Its style sheet imports normalize.css from a path of Debian's web servers, and lacks the rules by which dark colours
follow the system; its script is a module that nothing loads as one.
"""

import re
from pathlib import Path

_NORMALIZE = Path("/usr/share/javascript/normalize.css/normalize.css")
_IMPORT = "@import url(/javascript/normalize.css/normalize.css);"
_DARK = re.compile(r'body\[data-theme="dark"\] \{.*?\}', re.DOTALL)


def complete(static):
    """Changes the files in `static`, the site's folder of them, where they still lack something."""
    style, script = static / "styles/furo.css", static / "scripts/furo.js"
    text = style.read_text().replace(_IMPORT, _NORMALIZE.read_text())
    if "prefers-color-scheme" not in text:
        dark = _DARK.search(text)[0].replace('[data-theme="dark"]', ':not([data-theme="light"])')
        text += f"\n@media not print {{ @media (prefers-color-scheme: dark) {{ {dark} }} }}\n"
    style.write_text(text)
    code = script.read_text()
    if code.startswith("import Gumshoe"):
        gumshoe = (static / "scripts/gumshoe-patched.js").read_text()
        script.write_text(gumshoe + code.partition("\n")[2])
