"""LLVM code of functions that an earlier build lowered, for a build of the same checkout; `front` lowers the others.

A function's code is kept under its name and the types of its arguments. It is used again if its sources are the same:
its bytecode, the constants, records and options that it refers to, and the symbol and the result of each function that
it calls. The code of these may have changed, because it is linked later. So an edit of a function costs that function,
and its callers only if its result has another type: a build takes 4 s in place of 88.

Symbols must be the same in each process. Numba numbers functions in the order in which it sees them. Here functions of
the package have a number by their content, and Numba's own a random one, because two of one name may be two functions.
"""

from __future__ import annotations

import copy
import functools
import hashlib
import inspect
import pickle
import secrets
import sys
import types as pythons
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import llvmlite
import numba
import numpy as np
from numba.core import bytecode, compiler, environment, serialize, sigutils, types

from conicoid._jit import compiler as own

HERE = Path(__file__).resolve().parent
INNER = "inner"
"""The name of the libraries of functions of the package (`conicoid._jit.compiler`)."""
PLAIN = int, float, bool, str, bytes, type(None), np.generic, np.dtype


class Link(NamedTuple):
    """A function that another one calls: its name there, argument types, symbol, type of result."""

    name: str
    arguments: bytes
    symbol: str
    result: str


class Record(NamedTuple):
    """The code of one function for some types of arguments, and its dependencies."""

    content: str
    signature: bytes
    descriptor: bytes
    links: list[Link]
    foreign: list[bytes]
    code: bytes


def edition() -> str:
    """Return a hash of the versions and files that turn any function into LLVM code."""
    digest = hashlib.sha256(repr((sys.version, numba.__version__, llvmlite.__version__, np.__version__)).encode())
    for path in (*sorted(Path(own.__file__).parent.glob("*.py")), HERE / "front.py", Path(__file__)):
        digest.update(path.read_bytes())
    return digest.hexdigest()


def _names(code: Any) -> Iterator[str]:
    yield from code.co_names
    for each in code.co_consts:
        if isinstance(each, pythons.CodeType):
            yield from _names(each)


def references(function: Any) -> dict[str, Any]:
    """Return the references of a function outside of itself, by name: globals, contents of modules, closures."""
    names = set(_names(function.__code__))
    cells = zip(function.__code__.co_freevars, function.__closure__ or (), strict=True)
    found = {name: cell.cell_contents for name, cell in cells}
    for name in names & function.__globals__.keys():
        found[name] = value = function.__globals__[name]
        if inspect.ismodule(value):
            found |= {f"{name}.{each}": getattr(value, each) for each in names if hasattr(value, each)}
    return found


def _content(value: Any) -> Any:
    """Return the part of a value on which code depends, complete in its `repr`."""
    if isinstance(value, PLAIN):
        return type(value).__name__, repr(value)
    if isinstance(value, tuple):
        return type(value).__qualname__, getattr(value, "_fields", ()), [_content(each) for each in value]
    if isinstance(value, np.ndarray):
        return value.dtype.str, value.shape, value.tobytes()
    if isinstance(value, own.Inner | own.Kernel):
        function = value.py_func
        cells = [_content(cell.cell_contents) for cell in function.__closure__ or ()]
        return function.__module__, function.__qualname__, repr(sorted(value.targetoptions.items())), cells
    if inspect.ismodule(value) or inspect.isbuiltin(value) or isinstance(value, np.ufunc):
        return value.__name__
    if isinstance(value, type) and hasattr(value, "_fields"):
        return value.__module__, value.__qualname__, value._fields
    value = getattr(value, "_defn", value)  # of one of Numba's intrinsics
    module = sys.modules.get(getattr(value, "__module__", None) or "")
    if module is None:
        return secrets.token_hex()  # without a known content: never the same
    return module.__name__, getattr(value, "__qualname__", ""), _of_module(module)


@functools.cache
def _of_module(module: Any) -> str:
    """Return a hash of the dependencies of code that a module writes: its file, its constants, and other modules."""
    digest, seen, waiting = hashlib.sha256(), {module}, [module]
    while waiting:
        each = waiting.pop()
        if not each.__name__.startswith("conicoid."):
            continue
        digest.update(Path(str(each.__file__)).read_bytes())
        for name, value in sorted(vars(each).items()):
            if isinstance(value, PLAIN) and not name.startswith("__"):
                digest.update(f"{name} {value!r}".encode())
            elif not isinstance(value, own.Inner | own.Kernel):
                owner = value if inspect.ismodule(value) else sys.modules.get(getattr(value, "__module__", None) or "")
                if owner is not None and owner not in seen:
                    seen.add(owner)
                    waiting.append(owner)
    return digest.hexdigest()


def _of_code(code: Any, words: str | None = None) -> Any:
    """Return the content of a function's bytecode, but for its docstring."""
    consts = [
        _of_code(each) if isinstance(each, pythons.CodeType) else "" if words and each is words else repr(each)
        for each in code.co_consts
    ]
    return code.co_code, code.co_exceptiontable, consts, code.co_names, code.co_varnames, code.co_cellvars


def content(function: Any, options: Any) -> str:
    """Return a hash of all that a function's code depends on, but for the results of functions that it calls."""
    found = {name: _content(value) for name, value in references(function).items()}
    every = (
        _of_code(function.__code__, function.__doc__),
        function.__defaults__,
        sorted(options.items()),
        sorted(found.items()),
    )
    return hashlib.sha256(repr(every).encode()).hexdigest()


def _number(function: Any) -> int:
    """Return a number that distinguishes functions of the same name."""
    if not function.__module__.startswith("conicoid."):
        return secrets.randbits(60)
    cells = [_content(cell.cell_contents) for cell in function.__closure__ or ()]
    return int(hashlib.sha256(repr(cells).encode()).hexdigest()[:12], 16)


@functools.cache
def described(kind: Any) -> str:
    """Return a type in words, with the names of the fields of records, which Numba omits."""
    if not isinstance(kind, types.BaseTuple):
        return str(kind)
    return f"{kind} {getattr(kind, 'fields', '')} {[described(each) for each in kind.types]}"


def read_parts(path: Path) -> Any:
    """Return the content of a file of `write_parts`, or ("", {}) where it cannot be read."""
    try:
        return pickle.loads(path.read_bytes())
    except (OSError, EOFError, ImportError, AttributeError, pickle.UnpicklingError):
        return "", {}


def write_parts(path: Path, parts: Any) -> None:
    """Write the parts of builds, in one step."""
    unfinished = path.with_suffix(".unfinished")
    unfinished.write_bytes(pickle.dumps(parts))
    unfinished.replace(path)


class Memory:
    """The code of functions from an earlier build, and of those that this one lowered (`compiled`)."""

    def __init__(self, path: Path) -> None:
        self._path, self._edition = path, edition()
        self._old: dict[str, Record] = {}
        self._libraries: dict[bytes, Any] = {}
        self._contents: dict[Any, str] = {}
        self._compile = own.Inner.compile
        self.compiled: list[str] = []
        found, records = read_parts(path)
        self._old = records if found == self._edition else {}
        self._new: dict[str, Record] = {}

    def bend(self) -> None:
        """Let functions be taken from here, and have symbols that do not depend on the process."""
        memory, made = self, bytecode.FunctionIdentity.from_function.__func__

        def from_function(cls: Any, function: Any) -> Any:
            identity = made(cls, function)
            identity.unique_id = _number(identity.func)
            identity.unique_name = f"{identity.func_qualname}${identity.unique_id}"
            return identity

        def take_or_compile(self: Any, signature: Any) -> Any:
            arguments = tuple(sigutils.normalize_signature(signature)[0])
            if arguments not in self.overloads and not memory._restored(self, arguments):
                memory.compiled.append(self.py_func.__qualname__)
                memory._compile(self, signature)
            return self.overloads[arguments].entry_point

        bytecode.FunctionIdentity.from_function = classmethod(from_function)
        own.Inner.compile = take_or_compile  # type: ignore[method-assign]

    def _content(self, dispatcher: Any) -> str:
        if dispatcher not in self._contents:
            self._contents[dispatcher] = content(dispatcher.py_func, dispatcher.targetoptions)
        return self._contents[dispatcher]

    def _key(self, dispatcher: Any, arguments: Any) -> str:
        function = dispatcher.py_func
        return f"{function.__module__}.{function.__qualname__}{_number(function)}{list(map(described, arguments))}"

    def _restored(self, dispatcher: Any, arguments: Any) -> bool:
        """Return whether the code of a function is known, and give it to the dispatcher."""
        key = self._key(dispatcher, arguments)
        record = self._old.get(key)
        if record is None or record.content != self._content(dispatcher):
            return False
        known, libraries = references(dispatcher.py_func), []
        try:
            descriptor, signature = pickle.loads(record.descriptor), pickle.loads(record.signature)
            arguments_of = [pickle.loads(link.arguments) for link in record.links]
        except (ImportError, AttributeError):  # a class in them has moved
            return False
        for link, wanted in zip(record.links, arguments_of, strict=True):
            called = known[link.name]
            called.compile(wanted)
            result = called.overloads[wanted]
            if (result.fndesc.llvm_func_name, described(result.fndesc.restype)) != (link.symbol, link.result):
                return False
            libraries.append(result.library)
        library = _library(record.code, libraries + [self._foreign(code) for code in record.foreign])
        target = dispatcher.targetctx
        entry = target.get_executable(library, descriptor, environment.Environment.from_fndesc(descriptor))
        target.insert_user_function(entry, descriptor, [library])
        dispatcher.add_overload(
            compiler.compile_result(
                target_context=target, typing_context=target.typing_context, library=library, entry_point=entry,
                fndesc=descriptor, signature=signature, objectmode=False, environment=None,
            )
        )  # fmt: skip
        self._new[key] = record
        return True

    def _foreign(self, code: bytes) -> Any:
        if code not in self._libraries:
            self._libraries[code] = _library(code, [])
        return self._libraries[code]

    def keep(self, dispatchers: list[Any], codes: dict[Any, bytes]) -> None:
        """Write the records of all functions that some reach, whose libraries' code is in `codes`."""
        seen, waiting = set(dispatchers), list(dispatchers)
        while waiting:
            dispatcher = waiting.pop()
            known = references(dispatcher.py_func)
            called = {name: each for name, each in known.items() if isinstance(each, own.Inner)}
            waiting += [each for each in called.values() if each not in seen]
            seen.update(called.values())
            owners = {
                result.library: (name, arguments, result)
                for name, each in called.items()
                for arguments, result in each.overloads.items()
            }
            for arguments, result in dispatcher.overloads.items():
                record = self._record(dispatcher, result, owners, codes)
                if record is not None:
                    self._new.setdefault(self._key(dispatcher, arguments), record)
        write_parts(self._path, (self._edition, self._new))

    def _record(self, dispatcher: Any, result: Any, owners: dict[Any, Any], codes: dict[Any, bytes]) -> Record | None:
        """Return the record of a compiled function, or None if it calls one that it does not refer to by name."""
        links, foreign = [], []
        for library in dict.fromkeys(result.library._linking_libraries):
            if library in owners:
                name, arguments, called = owners[library]
                symbol, kind = called.fndesc.llvm_func_name, described(called.fndesc.restype)
                links.append(Link(name, serialize.dumps(arguments), symbol, kind))
            elif library.name == INNER:
                return None
            else:
                foreign += [codes[each] for each in own._reachable_libraries([library])]
        descriptor = copy.copy(result.fndesc)
        descriptor.typemap = descriptor.calltypes = None
        return Record(
            self._content(dispatcher),
            serialize.dumps(result.signature),
            serialize.dumps(descriptor),
            links,
            foreign,
            codes[result.library],
        )


def _library(code: bytes, linked: list[Any]) -> Any:
    """Return a finished library of known code, with the parts that its callers read."""
    library = object.__new__(own._InnerLibrary)
    library._name, library._linking_libraries, library._finalized = "kept", linked, True
    library._reload_init, library.code = set(), code
    library._codegen = None
    return library
