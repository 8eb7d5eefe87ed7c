"""Formulas as MathML, which browsers draw by themselves: no script, and no fonts from elsewhere."""

from __future__ import annotations

import re
from typing import Any

from latex2mathml.converter import convert
from sphinx.errors import SphinxError

_LEFT_OVER = re.compile(r">\\[A-Za-z]+<")  # a command that the converter did not know stands in its output as a word
_STYLED = re.compile(r'<mi mathvariant="(bold|sans-serif)">([A-Za-z])</mi>')
_ALPHABETS = {"bold": (0x1D400, 0x1D41A), "sans-serif": (0x1D5A0, 0x1D5BA)}  # Unicode's A and a of each


def mathml(formula: str, display: str) -> str:
    """A formula in LaTeX as a `math` element. Raises SphinxError for what cannot be translated."""
    markup = str(convert(formula, display=display))
    unknown = _LEFT_OVER.search(markup)
    if unknown:
        raise SphinxError(f"formula {formula!r}: unknown command {unknown[0][1:-1]}")
    return _STYLED.sub(_letter, markup)


def _letter(found: re.Match[str]) -> str:
    """A letter in bold or without serifs, by its own code point, since browsers forget `mathvariant`."""
    upper, lower = _ALPHABETS[found[1]]
    letter = found[2]
    return (
        f"<mi>{chr((upper if letter.isupper() else lower) + ord(letter) - ord('A' if letter.isupper() else 'a'))}</mi>"
    )


def _inline(translator: Any, node: Any) -> None:
    from docutils.nodes import SkipNode

    translator.body.append(mathml(node.astext(), "inline"))
    raise SkipNode


def _block(translator: Any, node: Any) -> None:
    from docutils.nodes import SkipNode

    translator.body.append(f'<div class="formula">{mathml(node.astext(), "block")}</div>\n')
    raise SkipNode


def connect(app: Any) -> None:
    """Make `html_math_renderer = "mathml"` possible."""
    app.add_html_math_renderer("mathml", (_inline, None), (_block, None))
