"""Conditions for an extension and a wheel before anybody gets them: `python -m native.inspection WHEEL...`.

An extension takes Python's stable ABI of 3.11 and a few functions on memory, strings and threads from others. It takes
none of their mathematics, which would decide bits. The inspection lists all faults.
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from zipfile import ZipFile

from abi3info import DATAS, FUNCTIONS
from abi3info.models import PyVersion

from . import wasm
from .binary import Binary, read
from .link import PAGE_ENGINE, extension_name
from .targets import TARGETS, Target

ROOT = Path(__file__).resolve().parents[1]
MOST_BYTES = 8 << 20
OLDEST_PYTHON = PyVersion(3, 11)
STABLE = {each.symbol.name for each in (*FUNCTIONS.values(), *DATAS.values()) if each.added <= OLDEST_PYTHON}

MEMORY = {"malloc", "free", "memcpy", "memmove", "memset", "strchr", "strcmp", "strlen"}
POSIX = {  # for threads, and large pages
    *("pthread_attr_destroy", "pthread_attr_init", "pthread_attr_setdetachstate", "pthread_attr_setstacksize"),
    *(
        "pthread_cond_broadcast",
        "pthread_cond_init",
        "pthread_cond_signal",
        "pthread_cond_wait",
        "pthread_condattr_init",
        "pthread_create",
    ),
    *("pthread_mutex_init", "pthread_mutex_lock", "pthread_mutex_unlock", "getpid"),
}
LINUX = {"pthread_cond_timedwait", "pthread_condattr_setclock", "clock_gettime", "madvise"}
WINDOWS_THREADS = {
    *("AcquireSRWLockExclusive", "CloseHandle", "CreateThread", "ReleaseSRWLockExclusive"),
    *("SleepConditionVariableSRW", "WakeAllConditionVariable", "WakeConditionVariable"),
}
START = {  # functions of Windows that the runtime of a DLL calls when it is loaded and left
    *("_execute_onexit_table", "_exit", "_initialize_onexit_table", "_initterm", "_initterm_e", "abort"),
    *("_register_onexit_function", "__acrt_iob_func", "__stdio_common_vfprintf", "fwrite"),
    *("DeleteCriticalSection", "EnterCriticalSection", "InitializeCriticalSection", "LeaveCriticalSection"),
    *("GetLastError", "Sleep", "TlsGetValue", "VirtualProtect", "VirtualQuery"),
}
IMPORTS = {
    "linux": MEMORY | POSIX | LINUX,
    "musl": MEMORY | POSIX | LINUX,
    "macos": MEMORY
    | POSIX
    | {"pthread_cond_timedwait_relative_np", "bzero", "__bzero", "memset_pattern16", "dyld_stub_binder"},
    "windows": MEMORY | START | WINDOWS_THREADS,
    "pyodide": MEMORY,
}
WINDOWS = "heap", "math", "private", "runtime", "stdio", "string"
LIBRARIES = {
    "linux": {"libc.so.6", "libpthread.so.0"},
    "musl": {"libc.so"},
    "macos": {"/usr/lib/libSystem.B.dylib"},
    "windows": {"python3.dll", "kernel32.dll", *(f"api-ms-win-crt-{part}-l1-1-0.dll" for part in WINDOWS)},
    "pyodide": set(),
}
MACHINES = {"x86_64": {"X86_64", "AMD64"}, "aarch64": {"AARCH64"}, "arm64": {"ARM64"}, "wasm32": {"WASM32"}}


def _listed(what: str, names: set[str] | frozenset[str]) -> Iterator[str]:
    if names:
        yield f"{what}: {', '.join(sorted(names))}"


def _oldest(target: Target) -> tuple[int, ...]:
    """Return the version of glibc or macOS in the tag of its wheels."""
    words = target.tag.split("_")
    return (int(words[1]), int(words[2])) if target.system in ("linux", "macos") else ()


def _of_this_machine(content: bytes) -> Iterator[str]:
    for place in (ROOT, Path.home() / ".cache", Path(sys.prefix), Path(tempfile.gettempdir()) / ""):
        if str(place).encode() in content:
            yield f"names a folder of the machine it was built on: {place}"


def wrong_with(binary: Binary, target: Target) -> Iterator[str]:
    """Return the faults of an extension for a target."""
    if binary.machine not in MACHINES[target.name.partition("-")[2]]:
        yield f"is for {binary.machine}"
    yield from _listed("takes what it may not", binary.imports - STABLE - IMPORTS[target.system])
    yield from _listed("needs libraries", binary.libraries - LIBRARIES[target.system])
    if binary.exports != {"PyInit__kernels"}:
        yield f"offers {', '.join(sorted(binary.exports))}, not PyInit__kernels alone"
    if binary.needs[:2] > _oldest(target):
        yield f"needs version {'.'.join(map(str, binary.needs))}, newer than its tag"
    if binary.stack_runs_code:
        yield "has a stack that runs code"
    if binary.search_path:
        yield "says where libraries are to be looked for"


def wrong_with_extension(path: Path, target: Target) -> list[str]:
    """Return the faults of the file of an extension."""
    return [*wrong_with(read(path), target), *_of_this_machine(path.read_bytes())]


def wrong_with_page_engine(code: bytes) -> Iterator[str]:
    """Return the faults of the engine for pages: it takes nothing from a page, whose functions could decide bits."""
    try:
        module = wasm.read(code)
    except ValueError as error:
        yield f"{PAGE_ENGINE} {error}"
        return
    if module.imports:
        yield f"{PAGE_ENGINE} takes something from the page"
    yield from _of_this_machine(code)


def target_of(wheel: Path) -> Target:
    """Return the target in a wheel's name."""
    for target in TARGETS.values():
        if wheel.name.endswith(f"-cp311-abi3-{target.tag}.whl"):
            return target
    raise ValueError(f"{wheel.name} is a wheel for none of the targets")


def wrong_with_wheel(wheel: Path) -> list[str]:
    """Return the faults of a wheel and the extension in it."""
    target, found = target_of(wheel), []
    name = f"conicoid/{extension_name(target)}"
    if wheel.stat().st_size > MOST_BYTES:
        found.append(f"has {wheel.stat().st_size:,} bytes, more than {MOST_BYTES:,}")
    with ZipFile(wheel) as archive, tempfile.TemporaryDirectory() as folder:
        names = archive.namelist()
        info = next(each.partition("/")[0] for each in names if ".dist-info/" in each)
        strays = {each for each in names if each.partition("/")[0] not in ("conicoid", info)}
        found += _listed("holds what does not belong to the package", strays)
        if f"{info}/licenses/LICENSE" not in names:
            found.append("has no licence")
        if PAGE_ENGINE in names:
            found += wrong_with_page_engine(archive.read(PAGE_ENGINE))
        else:
            found.append(f"has no {PAGE_ENGINE}")
        about = archive.read(f"{info}/WHEEL").decode().splitlines()
        wanted = {"Root-Is-Purelib: false", f"Tag: cp311-abi3-{target.tag}"}
        found += _listed("does not say", wanted - set(about))
        if [each for each in names if each.startswith("conicoid/_kernels")] != [name]:
            return [*found, f"does not hold {name} alone"]
        return found + wrong_with_extension(Path(archive.extract(name, folder)), target)


def wrong_with_cuda_wheel(wheel: Path) -> list[str]:
    """Return the faults of a wheel of kernels for GPUs."""
    from . import ptx

    found = []
    with ZipFile(wheel) as archive:
        names = archive.namelist()
        info = next(each.partition("/")[0] for each in names if ".dist-info/" in each)
        wanted = {
            f"conicoid_cuda/{name}" for name in ("__init__.py", ptx.STAMP, *(f"{each}.ptx" for each in ptx.NAMES))
        }
        machine_code = {f"conicoid_cuda/{each}" for each in ptx.CUBINS}
        held = {each for each in names if each.partition("/")[0] != info}
        wanted |= machine_code if held & machine_code else set()
        found += [*_listed("does not hold", wanted - held), *_listed("holds what does not belong", held - wanted)]
        if f"{info}/licenses/LICENSE" not in names:
            found.append("has no licence")
        for name in names:
            found += [f"{name} {wrong}" for wrong in _of_this_machine(archive.read(name))]
    return found


def main() -> int:
    """Inspect wheels; return 1 if one has a fault."""
    wrong = 0
    for wheel in map(Path, sys.argv[1:]):
        found = (wrong_with_cuda_wheel if wheel.name.startswith("conicoid_cuda-") else wrong_with_wheel)(wheel)
        wrong += bool(found)
        print(f"{wheel.name}: {'; '.join(found) or 'as it should be'}")
    return int(wrong > 0)


if __name__ == "__main__":
    sys.exit(main())
