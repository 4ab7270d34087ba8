"""Formulas as MathML, which browsers draw themselves: no script, no font and no other host are needed."""

import re
from html import escape
from typing import Any

from docutils import nodes
from latex2mathml.converter import convert
from sphinx.application import Sphinx
from sphinx.util.math import get_node_equation_number


def setup(app: Sphinx) -> dict[str, Any]:
    """Register the renderer as `mathml`; a formula that cannot be converted stops the build."""
    app.add_html_math_renderer("mathml", (_inline, None), (_block, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def _inline(writer: Any, node: nodes.math) -> None:
    writer.body.append(_mathml(node.astext(), "inline"))
    raise nodes.SkipNode


def _block(writer: Any, node: nodes.math_block) -> None:
    writer.body.append(writer.starttag(node, "div", CLASS="formula"))
    writer.body.append(_mathml(node.astext(), "block"))
    if node.get("number"):
        writer.body.append(f'<span class="number">({escape(get_node_equation_number(writer, node))})</span>')
    writer.body.append("</div>\n")
    raise nodes.SkipNode


def _mathml(formula: str, display: str) -> str:
    # The converter leaves no space between the name of a function and its argument.
    return re.sub(
        r"(<mi>(?:sin|cos|ln)</mi>)(?=<m(?:i|sub|frac)>)",
        r'\1<mspace width="0.17em"/>',
        convert(formula, display=display),
    )
