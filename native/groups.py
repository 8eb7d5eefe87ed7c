"""Machine code of the kernels for a checkout: an object for each source file, made again where its code has changed.

A wheel's kernels are one module, which LLVM simplifies and optimises as a whole. Here each source file is a module,
with the functions of other files that LLVM is to inline; it calls the larger ones. The answers are the same to the bit.
An object is kept under the hash of its code: after an edit of a function the build makes the files again that copy it.
"""

from __future__ import annotations

import hashlib
import os
import pickle
from collections import defaultdict
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any, NamedTuple

import llvmlite
import llvmlite.binding as llvm
from llvmlite import ir

from .memory import read_parts, write_parts
from .objects import DROPPED, _entry, clean, hold, machine_for, optimize, simplify
from .targets import Target

SMALL = 60
"""Instructions of a function that is copied into the files that call it."""


class Part(NamedTuple):
    """A function with the code that Numba made beside it: clean code, symbols that it defines and calls, its file."""

    code: bytes
    defined: tuple[str, ...]
    called: tuple[str, ...]
    copied: bool
    file: str


def _file(symbol: str) -> str:
    """Return the module of a function of the package, from its symbol; "" for another function."""
    words, at = [], 3
    while symbol.startswith("_ZN") and symbol[at].isdigit():
        end = at
        while symbol[end].isdigit():
            end += 1
        at = end + int(symbol[at:end])
        words.append(symbol[end:at])
    return ".".join(words[:-1]) if words[:1] == ["conicoid"] else ""


def _part(code: bytes, target: Target) -> Part:
    """Return a function's part, with the data for its file's object."""
    machine = machine_for(target.triple, target.levels[0])
    module = llvm.parse_bitcode(code)
    module.data_layout, module.triple = str(machine.target_data), target.triple
    for each in (*module.functions, *module.global_variables):
        if not each.is_declaration and each.linkage in DROPPED:
            each.linkage = "weak_odr"
    clean(module, machine)
    defined = [each for each in module.functions if not each.is_declaration]
    size = sum(1 for each in defined for block in each.blocks for _ in block.instructions)
    inlined = any(b"alwaysinline" in words for each in defined for words in each.attributes)
    called = tuple(each.name for each in module.functions if each.is_declaration)
    file = next(filter(None, (_file(each.name) for each in defined)), "")
    names = tuple(each.name for each in defined)
    return Part(module.as_bitcode(), names, called, inlined or size <= SMALL or not file, file)


class _Group(NamedTuple):
    """The content of one object: parts of one file and copies of others, symbols seen by other files, entry points."""

    parts: list[bytes]
    seen: list[str]
    entries: dict[str, Any]


def groups(kernels: dict[str, dict[str, Any]], parts: list[Part]) -> dict[str, _Group]:
    """Return the groups of functions that become objects, by file."""
    owner = {name: number for number, part in reversed(list(enumerate(parts))) for name in part.defined}
    members, copies, seen = defaultdict(list), {}, set()
    for number in sorted(set(owner.values())):
        if parts[number].file:
            members[parts[number].file].append(number)
    for file, own in members.items():
        found, waiting = dict.fromkeys(own), list(own)
        while waiting:
            for name in parts[waiting.pop()].called:
                number = owner.get(name)
                if number is None or number in found:
                    continue
                if parts[number].copied:
                    found[number] = None
                    waiting.append(number)
                else:
                    seen.add(name)
        # In order, because builds see functions in different orders
        copies[file] = sorted(found, key=lambda number: (number not in own, parts[number].defined))
    made = {}
    for file, numbers in copies.items():
        names = {name for number in members[file] for name in parts[number].defined}
        # Without the numbers of the functions that a kernel calls: an edit in any file shifts them
        entries = {
            name: {key: kernel[key] for key in kernel if key != "functions"}
            for name, kernel in kernels.items()
            if kernel["symbol"] in names
        }
        made[file] = _Group([parts[number].code for number in numbers], sorted(names & seen), entries)
    return made


def _object(group: _Group, target: Target) -> bytes:
    """Return the object of a group."""
    (level,) = target.levels
    machine = machine_for(target.triple, level)
    whole, *others = map(llvm.parse_bitcode, group.parts)
    for each in others:
        whole.link_in(each)
    entries = ir.Module("entries")
    entries.triple, entries.data_layout = target.triple, str(machine.target_data)
    for name, kernel in group.entries.items():
        _entry(entries, level.prefix + name, kernel)
    whole.link_in(llvm.parse_assembly(str(entries)))
    seen = {*group.seen, *(level.prefix + name for name in group.entries)}
    for each in (*whole.functions, *whole.global_variables):
        if not each.is_declaration:
            each.linkage = "external" if each.name in seen else "internal"
            each.visibility = "hidden" if each.name in seen else "default"
    whole.verify()
    simplify(whole, machine)
    optimize(whole, machine)
    hold(whole, _file)
    return bytes(machine.emit_object(whole))


def _edition() -> str:
    """Return a hash of the sources that make objects from code."""
    here = Path(__file__).parent
    digest = hashlib.sha256(f"{llvmlite.__version__} {llvm.llvm_version_info}".encode())
    for name in ("groups.py", "objects.py", "targets.py", "arithmetic.py"):
        digest.update((here / name).read_bytes())
    return digest.hexdigest()


def build(code: Path, target: Target, folder: Path) -> list[Path]:
    """Return the objects of a target's only level, and make those that the folder lacks; older ones are removed."""
    kernels, codes = pickle.loads(code.read_bytes())
    store = folder / "objects"
    store.mkdir(exist_ok=True)
    edition, kept = f"{_edition()} {target}", folder / "parts.pickle"
    found, known = read_parts(kept)
    known = known if found == edition else {}
    with ProcessPoolExecutor(os.cpu_count()) as pool:
        codes = list(dict.fromkeys(codes))
        new = [each for each in codes if each not in known]
        known |= zip(new, pool.map(_part, new, [target] * len(new), chunksize=20), strict=True)
        known = {each: known[each] for each in codes}
        write_parts(kept, (edition, known))
        wanted = {}
        for file, group in groups(kernels, list(known.values())).items():
            digest = hashlib.sha256(repr((edition, group)).encode()).hexdigest()[:24]
            wanted[store / f"{file}-{digest}.o"] = group
        missing = [path for path in wanted if not path.exists()]
        objects = pool.map(_object, [wanted[path] for path in missing], [target] * len(missing))
        for path, made in zip(missing, objects, strict=True):
            unfinished = path.with_suffix(".unfinished")
            unfinished.write_bytes(made)
            unfinished.replace(path)
    for path in store.glob("*.o"):
        if path not in wanted:
            path.unlink()
    return list(wanted)
