"""Plain commands, understood without Typer: to import that takes longer than many a picture.

`conicoid render SCENE -o PICTURE`, with options that are whole numbers, is all of it. Whatever else is written, and
whatever may be a mistake, is left to the command line proper, with its messages.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from .exit_codes import DONE
from .terminal import user_mistakes

_NUMBERS = "--width", "--height", "--samples", "--threads"
_OUTPUT = "-o", "--output"
_DIGITS = 9
NOTHING_SEEN = "; --fit takes a camera that sees all that is bounded"


def understood(arguments: Sequence[str]) -> Callable[[], int] | None:
    """What does a command, and returns its exit code; None where the command line has to say what is meant."""
    if not arguments or arguments[0] != "render":
        return None
    numbers: dict[str, int] = {}
    outputs, scenes, rest = [], [], list(arguments[1:])
    while rest:
        word = rest.pop(0)
        if not word.startswith("-") and word:
            scenes.append(word)
            continue
        if word not in (*_NUMBERS, *_OUTPUT) or word in numbers or not rest:
            return None
        value = rest.pop(0)
        if word in _OUTPUT:
            outputs.append(value)
        elif value.isascii() and value.isdigit() and len(value) <= _DIGITS and int(value) > 0:
            numbers[word] = int(value)
        else:
            return None
    if len(outputs) != 1 or len(scenes) != 1 or not outputs[0] or outputs[0].startswith("-"):
        return None
    return lambda: _render(Path(scenes[0]), Path(outputs[0]), {name[2:]: each for name, each in numbers.items()})


def _render(scene: Path, output: Path, numbers: dict[str, int]) -> int:
    """A picture with the options of `render` that are given."""
    from ..environment import check_environment

    with user_mistakes():
        check_environment()
        from ..collector import without_collector
        from ..render.picture import check_options
        from .drawing import Wanted, draw
        from .working import load

        threads = numbers.pop("threads", None)
        wanted = Wanted(output, **numbers)  # type: ignore[arg-type]
        wanted.check_output()
        check_options(wanted.samples, wanted.integrator, wanted.seed, wanted.depth)
        with without_collector():  # one scene is made and drawn, and then the process ends
            draw(load(scene, threads), None, wanted, NOTHING_SEEN)
    return DONE
