"""What Numba does with an inner function, less what none of ours needs.

Inner functions have no closures, no `with`, no literal arguments and no arithmetic on whole arrays.
"""

from __future__ import annotations

from typing import Any

from numba import types
from numba.core import typed_passes, typing, untyped_passes
from numba.core.compiler_machinery import PassManager
from numba.core.targetconfig import ConfigStack

_PASSES = (
    untyped_passes.TranslateByteCode,
    untyped_passes.FixupArgs,
    untyped_passes.IRProcessing,
    untyped_passes.GenericRewrites,
    untyped_passes.ReconstructSSA,
    typed_passes.NopythonTypeInference,
    typed_passes.PreLowerStripPhis,
    typed_passes.InlineOverloads,
    typed_passes.IRLegalization,
    typed_passes.AnnotateTypes,
    typed_passes.NativeLowering,
    typed_passes.NoPythonBackend,
)


def passes() -> PassManager:
    """From the bytecode of an inner function to its LLVM code."""
    manager = PassManager("inner")
    for each in _PASSES:
        manager.add_pass(each, each.__name__)
    manager.finalize()
    return manager


class _Typing(typing.Context):
    """Numba's types of functions, with a memory: it tries some dozen templates for each + it meets."""

    _memory: dict[Any, Any]

    def resolve_function_type(self, function: Any, arguments: Any, names: Any) -> Any:
        """The type of a call, remembered for each function, arguments and flags."""
        if not isinstance(function, types.Function) or names:
            return super().resolve_function_type(function, arguments, names)
        flags = ConfigStack.top_or_none()
        key = function, arguments, flags and (flags.forceinline, flags.nrt)
        known = self._memory.get(key)
        if known is None:
            known = self._memory[key] = super().resolve_function_type(function, arguments, names)
        return known


_views: dict[int, _Typing] = {}


def with_memory(context: Any) -> Any:
    """The same context, all that it holds shared, with a memory."""
    if isinstance(context, _Typing):
        return context
    view = _views.get(id(context))
    if view is None:
        view = object.__new__(_Typing)
        context._memory = {}
        view.__dict__ = context.__dict__
        _views[id(context)] = view
    return view
