"""Ctrl-C at one of the calls of a function."""

from collections.abc import Callable
from typing import Any


class Interruption:
    """A function, such as for `progress`, that raises KeyboardInterrupt at one of its calls; `usual` has its results."""

    def __init__(self, at: int = 1, usual: Callable[..., Any] = lambda *_: None) -> None:
        self.at, self.usual, self.calls = at, usual, list[Any]()

    def __call__(self, *arguments: Any) -> Any:
        self.calls.append(arguments)
        if len(self.calls) == self.at:
            raise KeyboardInterrupt
        return self.usual(*arguments)
