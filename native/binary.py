"""An extension as a platform's loader sees it: one description for ELF, Mach-O, PE (read by LIEF) and WebAssembly."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import lief

from . import wasm

Version = tuple[int, ...]


@dataclass(frozen=True)
class Binary:
    """The description of an extension. Names are those of C, without a platform's prefixes."""

    machine: str
    imports: frozenset[str]  # other libraries must define these
    libraries: frozenset[str]  # they must be there
    exports: frozenset[str]
    needs: Version  # the oldest glibc or macOS that is enough; () on other systems
    stack_runs_code: bool
    search_path: bool  # does the file name folders of libraries?


def _glibc(text: str) -> Version:
    """Return the numbers in "GLIBC_2.17"."""
    found = re.fullmatch(r"GLIBC_([\d.]+)", text)
    return tuple(map(int, found[1].split("."))) if found else ()


def _elf(found: Any) -> Binary:
    tags, symbols = lief.ELF.DynamicEntry.TAG, [each for each in found.dynamic_symbols if each.name]
    needed = [version.name for group in found.symbols_version_requirement for version in group.get_auxiliary_symbols()]
    return Binary(
        machine=found.header.machine_type.name,
        imports=frozenset(each.name for each in symbols if each.shndx == 0),
        libraries=frozenset(found.libraries),
        exports=frozenset(each.name for each in symbols if each.shndx != 0),
        needs=max(map(_glibc, needed), default=()),
        stack_runs_code=not found.has_nx,
        search_path=found.has(tags.RUNPATH) or found.has(tags.RPATH),
    )


_MADE_BY_THE_LINKER = {"_mh_dylib_header", "__dso_handle"}


def _mach_o(found: Any) -> Binary:
    """Describe a library of macOS.

    The loader searches all libraries for Python's names, and for other names the library where the linker saw them.
    """
    flat = {each.name for each in found.imported_symbols if each.binding_info.library_ordinal == -2}
    imports = {each.name for each in found.imported_symbols}
    strays = {f"{name} in no library" for name in flat if not name.lstrip("_").startswith("Py")}
    needs = found.build_version.minos if found.has_build_version else found.version_min.version
    own = found.get(lief.MachO.LoadCommand.TYPE.ID_DYLIB).name
    return Binary(
        machine=found.header.cpu_type.name,
        imports=frozenset(name.removeprefix("_") for name in imports | strays),
        libraries=frozenset(each.name for each in found.libraries if each.name != own),
        exports=frozenset(each.name.removeprefix("_") for each in found.exported_symbols) - _MADE_BY_THE_LINKER,
        needs=tuple(needs),
        stack_runs_code=not found.has_nx_stack,
        search_path=found.has_rpath,
    )


def _pe(found: Any) -> Binary:
    return Binary(
        machine=found.header.machine.name,
        imports=frozenset(entry.name for library in found.imports for entry in library.entries),
        libraries=frozenset(library.name.lower() for library in found.imports),
        exports=frozenset(each.name for each in found.exported_functions),
        needs=(),
        stack_runs_code=not found.has_nx,
        search_path=False,
    )


_FROM_THE_LOADER = {
    *("memory", "__indirect_function_table", "__stack_pointer", "__memory_base", "__table_base"),
}
_FOR_THE_LOADER = {"__wasm_apply_data_relocs", "__wasm_call_ctors"}


def _side_module(code: bytes) -> Binary:
    """Describe a library in WebAssembly. It imports others' data from a table, which is a module by name."""
    found = wasm.read(code)
    others = {module for module, _ in found.imports} - {"env", "GOT.mem", "GOT.func"}
    return Binary(
        machine="WASM32",
        imports=frozenset(name for _, name in found.imports) - _FROM_THE_LOADER,
        libraries=frozenset(others),
        exports=frozenset(found.exports - _FOR_THE_LOADER),
        needs=(),
        stack_runs_code=False,
        search_path=False,
    )


def read(path: Path) -> Binary:
    """Return the description of a file. ValueError unless it is a library of one of the kinds."""
    code = path.read_bytes()
    if code.startswith(b"\0asm"):
        return _side_module(code)
    lief.logging.disable()
    found = lief.parse(str(path))
    for kind, describe in ((lief.ELF.Binary, _elf), (lief.MachO.Binary, _mach_o), (lief.PE.Binary, _pe)):
        if isinstance(found, kind):
            return describe(found)
    raise ValueError(f"{path} is no library of Linux, macOS, Windows or a browser")
