"""A million atoms: how long files of them take to read, and their scene to answer its first ray.

    python benchmarks/molecules.py [ATOMS]

Seconds of the clock and of the processor, in a process of its own for each: from the start of Python to the answer.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

PROGRAM = """
import sys, time, resource
begin = time.perf_counter()
import conicoid as co
atoms = co.molecule(sys.argv[1])
read = time.perf_counter()
scene = atoms.scene("space filling")
scene.first_hit((0, 0, -1e4), (0, 0, 1))
ready = time.perf_counter()
bonds = len(atoms.bonds)
print(f"{read - begin:.2f} {ready - read:.2f} {time.perf_counter() - ready:.2f} "
      f"{resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6:.2f} {bonds}")
"""


def written(folder: Path, count: int) -> list[Path]:
    """The same atoms as XYZ, PDB and mmCIF: as far apart as in a protein, of its usual elements."""
    rng = np.random.default_rng(1)
    side = (count / 0.1) ** (1 / 3)  # a tenth of an atom per cubic angstrom
    places, symbols = rng.uniform(0, side, (count, 3)), rng.choice(list("HHHHHCCCNOS"), count).tolist()
    rows = list(zip(symbols, places.tolist(), strict=True))
    xyz, pdb, cif = (folder / f"atoms.{suffix}" for suffix in ("xyz", "pdb", "cif"))
    xyz.write_text(f"{count}\n\n" + "".join(f"{s} {x:.3f} {y:.3f} {z:.3f}\n" for s, (x, y, z) in rows))
    pdb.write_text(
        "".join(
            f"ATOM  {k % 100000:5d}  {s}   GLY A{k // 8 % 10000:4d}    {x:8.3f}{y:8.3f}{z:8.3f}  1.00  0.00{s:>12}\n"
            for k, (s, (x, y, z)) in enumerate(rows)
        )
    )
    heads = "type_symbol label_atom_id auth_seq_id Cartn_x Cartn_y Cartn_z".split()
    text = "data_a\nloop_\n" + "".join(f"_atom_site.{head}\n" for head in heads)
    cif.write_text(text + "".join(f"{s} {s} {k} {x:.3f} {y:.3f} {z:.3f}\n" for k, (s, (x, y, z)) in enumerate(rows)))
    return [xyz, pdb, cif]


def main() -> None:
    count = int(float(sys.argv[1])) if len(sys.argv) > 1 else 1_000_000
    print(f"{count:,} atoms   whole process    read   first ray   bonds   GB at most")
    with tempfile.TemporaryDirectory() as folder:
        for path in written(Path(folder), count):
            begin = time.perf_counter()
            done = subprocess.run(
                [sys.executable, "-c", PROGRAM, str(path)], capture_output=True, text=True, check=True
            )
            read, ready, bonds, memory, found = done.stdout.split()
            whole = time.perf_counter() - begin - float(bonds)
            print(f"{path.suffix:<12}{whole:15.2f} s{read:>8}{ready:>12}{bonds:>8}{memory:>13}   {int(found):,} bonds")


if __name__ == "__main__":
    main()
