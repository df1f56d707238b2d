"""What the site has and the Markdown files have not: pages of every public name, links from a name to its page.

A page that loads anything from another host is an error.
"""

from __future__ import annotations

import inspect
import re
from pathlib import Path
from typing import TYPE_CHECKING

from docutils import nodes
from public_names import by_room, first_line
from site_hosts import in_site
from sphinx.addnodes import pending_xref
from sphinx.errors import ExtensionError
from sphinx.transforms import SphinxTransform

import asmc_pin
from asmc_pin.parameters import parameters_of

if TYPE_CHECKING:
    from sphinx.application import Sphinx

    from asmc_pin.parameters import Parameter

# What a docstring shows as code, and what reStructuredText would take for a mark of its own in the rest.
_CODE_OR_MARK = re.compile(r"(``.+?``|(?<!`)`[^`]+`)|([|*]|(?<=\w)_(?!\w))")

_ARRAY = re.compile(r"~?numpy\.ndarray\[tuple\[~?(?:typing\.)?Any, \.\.\.\], ~?numpy\.dtype\[~?numpy\.float64\]\]")

_MODULES = re.compile(r"~?\b(?:[A-Za-z_]\w*\.)+(?=[A-Za-z_])")
_PRIVATE = re.compile(r", _\w+: [^,()]+(?=[,)])")


def write_name_pages(app: Sphinx) -> None:
    """One page for each room that has public names, made at every build; git does not keep them."""
    folder = app.srcdir / "docs" / "api"
    folder.mkdir(exist_ok=True)
    wanted = {}
    for room, names in by_room().items():
        title = f"Names of {room}"
        lines = [title, "=" * len(title), "", ".. currentmodule:: asmc_pin", ""]
        for name in names:
            thing = getattr(asmc_pin, name)
            if inspect.isfunction(thing) or isinstance(thing, type):
                lines += [f".. auto{'function' if inspect.isfunction(thing) else 'class'}:: asmc_pin.{name}"]
                lines += ["   :inherited-members:", ""] if _has_hidden_base(thing) else [""]
            else:  # a registry: its docstring would be that of a dictionary
                lines += [f".. py:data:: {name}", "", f"   {first_line(name)}", ""]
        wanted[folder / f"{room.replace('.', '_')}.rst"] = "\n".join(lines)
    for path in set(folder.glob("*.rst")) - set(wanted):
        path.unlink()
    for path, text in wanted.items():
        if not path.is_file() or path.read_text(encoding="utf-8") != text:
            path.write_text(text, encoding="utf-8")


def _has_hidden_base(thing: object) -> bool:
    """Whether a class gets methods from one of ours that has no page, and none from somebody else's."""
    bases = thing.__mro__[1:-1] if isinstance(thing, type) else ()
    ours = all(base.__module__.startswith("asmc_pin.") for base in bases)
    return ours and any(base.__name__ not in asmc_pin.__all__ for base in bases)


def plain_marks(app: Sphinx, what: str, name: str, thing: object, options: object, lines: list[str]) -> None:
    """Docstrings are plain text with code in backticks: `|s|` is no substitution in them, and `M_` no link."""
    if what == "class":
        told = parameters_of(thing).values()
        lines += ["", "Attributes:", *(f"    {each.name}: {_about(each)}" for each in told)] if told else []
    lines[:] = [_CODE_OR_MARK.sub(lambda found: found[1] or "\\" + found[2], line) for line in lines]


def _about(parameter: Parameter) -> str:
    return ", ".join(filter(None, (parameter.meaning, parameter.unit, parameter.takes)))


def no_types_in_prose(app: Sphinx, what: str, name: str, thing: object, options: object, lines: list[str]) -> None:
    """Types stand in annotations, so what a docstring says before a colon of what it is or returns is prose."""
    if told := [line for line in lines if line.startswith(":type: ")]:
        lines[:] = [f"{told[0].removeprefix(':type: ')}: {lines[0]}", *(line for line in lines[1:] if line not in told)]
    said = [line for line in lines if line.startswith(":rtype: ")]
    lines[:] = [line for line in lines if line not in said]
    for line in said:
        at = next(i for i, other in enumerate(lines) if other.startswith(":returns: "))
        lines[at] = lines[at].replace(":returns:", f":returns: {line.removeprefix(':rtype: ')}:", 1)


def short_types(
    app: Sphinx, what: str, name: str, thing: object, options: object, signature: str | None, returns: str | None
) -> tuple[str | None, str | None]:
    """Signatures say `Array` where numpy's type would fill a line, and names without the modules that they are in."""

    def short(text: str | None) -> str | None:
        return text and _PRIVATE.sub("", _MODULES.sub("", _ARRAY.sub("Array", text)))

    return short(signature), short(returns)


class NamesAreLinks(SphinxTransform):
    """Wherever a page shows `asmc_pin.NAME` as code, the name leads to its page."""

    default_priority = 210

    def apply(self) -> None:
        """Put a reference around every such piece of code that stands in running text."""
        for literal in list(self.document.findall(nodes.literal)):
            module, _, name = literal.astext().partition(".")
            if module == "asmc_pin" and name in asmc_pin.__all__ and not isinstance(literal.parent, nodes.reference):
                link = pending_xref("", refdomain="py", reftype="obj", reftarget=f"asmc_pin.{name}", refexplicit=True)
                link["refdoc"] = self.env.docname
                literal.replace_self(link)
                link += literal


def lead_to_the_first_page(app: Sphinx, failed: Exception | None) -> None:
    """A page at the top of the site that goes on to the first one, which lies in the folder of the documentation."""
    if failed is None and app.builder.format == "html":
        top: Path = app.outdir / "index.html"
        top.write_text(
            '<!doctype html>\n<html lang="en">\n<meta charset="utf-8">\n<title>asmc_pin</title>\n'
            '<meta http-equiv="refresh" content="0; url=docs/index.html">\n<a href="docs/index.html">asmc_pin</a>\n',
            encoding="utf-8",
        )


def nothing_from_elsewhere(app: Sphinx, failed: Exception | None) -> None:
    """The site is read without a network: no script, style, font or picture may come from another host.

    Raises:
        ExtensionError: One does.
    """
    if failed is None and app.builder.format == "html":
        found = [f"{path.relative_to(app.outdir)} loads {address}" for path, address in in_site(Path(app.outdir))]
        if found:
            raise ExtensionError("the site would need a network:\n" + "\n".join(found))


def setup(app: Sphinx) -> dict[str, bool]:
    """Connect all of that to Sphinx."""
    app.connect("builder-inited", write_name_pages)
    app.connect("autodoc-process-docstring", plain_marks, priority=400)
    app.connect("autodoc-process-docstring", no_types_in_prose, priority=600)
    app.connect("autodoc-process-signature", short_types)
    app.connect("build-finished", lead_to_the_first_page)
    app.connect("build-finished", nothing_from_elsewhere)
    app.add_transform(NamesAreLinks)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
