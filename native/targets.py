"""Targets of machine code: platforms, and levels of their processors."""

from __future__ import annotations

from dataclasses import dataclass, replace


@dataclass(frozen=True)
class Level:
    """A kind of processor, by LLVM's names."""

    name: str  # the name that users see and choose
    processor: str
    features: str = ""
    needs: int = 0  # `processor` of native/levels.h must find this

    @property
    def prefix(self) -> str:
        """The prefix of the symbols of its kernels."""
        return f"conicoid_{self.name.replace('-', '_')}_"


@dataclass(frozen=True)
class Target:
    """A platform of wheels, with the levels of its processors, the plainest first."""

    name: str
    triple: str  # LLVM's; both kinds of Linux have the same objects
    zig: str  # the linker's
    tag: str  # of a wheel
    levels: tuple[Level, ...]

    @property
    def system(self) -> str:
        """One of "linux" (with glibc), "musl", "macos", "windows" and "pyodide" (Python in a browser)."""
        return self.name.partition("-")[0]

    def only(self, names: str) -> Target:
        """Return the target with some of its levels, by their names with commas between them; "" for all."""
        some = tuple(level for level in self.levels if not names or level.name in names.split(","))
        return replace(self, levels=some)


# Vectors of 512 bits where they run at full rate: the choice of a level asks for more than AVX-512 (native/levels.h)
X86 = (
    Level("x86-64-v2", "x86-64-v2"),
    Level("x86-64-v3", "x86-64-v3", needs=1),
    Level("x86-64-v4", "x86-64-v4", "-prefer-256-bit", needs=2),
)
ARM = (Level("arm64", "generic"),)
APPLE = (Level("arm64", "apple-m1"),)

# Vectors of 128 bits are as exact as scalars. Relaxed ones, which are not, are left out. Browsers since mid-2023 have
# them.
_IN_BROWSERS = "+simd128,+bulk-memory,+bulk-memory-opt,+sign-ext,+nontrapping-fptoint,+mutable-globals,-extended-const"
WASM = (Level("wasm32", "generic", _IN_BROWSERS),)

TARGETS = {
    each.name: each
    for each in (
        Target("linux-x86_64", "x86_64-unknown-linux-gnu", "x86_64-linux-gnu.2.17", "manylinux_2_17_x86_64", X86),
        Target("linux-aarch64", "aarch64-unknown-linux-gnu", "aarch64-linux-gnu.2.17", "manylinux_2_17_aarch64", ARM),
        Target("musl-x86_64", "x86_64-unknown-linux-gnu", "x86_64-linux-musl", "musllinux_1_2_x86_64", X86),
        Target("musl-aarch64", "aarch64-unknown-linux-gnu", "aarch64-linux-musl", "musllinux_1_2_aarch64", ARM),
        Target("macos-x86_64", "x86_64-apple-macosx10.13.0", "x86_64-macos.10.13", "macosx_10_13_x86_64", X86),
        Target("macos-arm64", "arm64-apple-macosx11.0.0", "aarch64-macos.11.0", "macosx_11_0_arm64", APPLE),
        Target("windows-x86_64", "x86_64-pc-windows-gnu", "x86_64-windows-gnu", "win_amd64", X86),
        Target("pyodide-wasm32", "wasm32-unknown-emscripten", "wasm32-wasi", "pyemscripten_2026_0_wasm32", WASM),
    )
}
