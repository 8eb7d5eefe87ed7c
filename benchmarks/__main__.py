"""`python -m benchmarks`: time the same rays in Conicoid and in its peers, or measure errors.

It runs in the repository, beside which the peers are installed: `pip install --group bench`.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated, Any

import typer

from conicoid.cli.options import Command
from conicoid.cli.resources import check_folder
from conicoid.cli.terminal import show_message, user_mistakes

app = typer.Typer(add_completion=False, pretty_exceptions_enable=False, rich_markup_mode="rich")


@app.command(
    cls=Command,
    epilog="Examples:\n\n  python -m benchmarks\n\n  python -m benchmarks --rows camera-1000 --rows build\n\n"
    "  python -m benchmarks --accuracy --rows sphere --picture errors.png\n\n"
    "Rows: camera, random, picture, build, growth and more against peers; arrays, beyond and serial, from arrays of "
    "NumPy, against the kernel alone; latency, import, command, memory against the limits that Conicoid sets itself."
    "\n\n"
    "The peers come with `pip install --group bench`; docs/performance.md says how to read the table, "
    "docs/accuracy.md that of accuracy.",
)
def bench(
    rows: Annotated[
        list[str] | None,
        typer.Option(
            "--rows",
            help="Only this row; may be repeated. With --accuracy: a shape, a family of rays, float32 or float64.",
            show_default=False,
        ),
    ] = None,
    quick: Annotated[
        bool, typer.Option("--quick", help="Small, as a test that all works; the ratios mean nothing.")
    ] = False,
    markdown: Annotated[
        bool, typer.Option("--markdown", help="Print the table as Markdown, as in the documentation.")
    ] = False,
    output: Annotated[
        Path | None, typer.Option("--json", help="Write the figures to a file as well.", show_default=False)
    ] = None,
    accuracy: Annotated[bool, typer.Option("--accuracy", help="Measure errors instead of times.")] = False,
    rays: Annotated[
        int | None, typer.Option(min=1, help="With --accuracy: rays of each row.", show_default="100000")
    ] = None,
    picture: Annotated[
        Path | None, typer.Option(help="With --accuracy: a picture of the errors, .png.", show_default=False)
    ] = None,
) -> None:
    """Time the same rays in Conicoid and in every peer that is installed, in turn; or measure how wrong each is."""
    with user_mistakes():
        from .comparison import suite as times
        from .comparison.accuracy import suite as errors

        # Before measurements of minutes
        for file in filter(None, (output, picture)):
            check_folder(file)
        if accuracy and quick and rays is not None:
            raise ValueError("benchmarks: give either --rays or --quick, which is 2000 of them")
        if accuracy:
            result = errors.measure(rows or (), rays or (2000 if quick else 100_000), output, picture, show_message)
        elif rays is not None or picture is not None:
            raise ValueError("benchmarks: --rays and --picture go with --accuracy")
        else:
            result = times.measure(rows or (), quick, output, show_message)
        if markdown:
            typer.echo(result.markdown)
        else:
            _show_table(result.table, result.about)


def _show_table(table: Any, about: list[str]) -> None:
    """Print a table and lines below it on stdout, as wide as they need to be."""
    from rich.console import Console

    wide = Console(highlight=False, soft_wrap=True, width=None if sys.stdout.isatty() else 200)
    wide.print(table)
    for line in about:
        wide.print(line, markup=False)


if __name__ == "__main__":
    with user_mistakes():
        app(prog_name="python -m benchmarks")
