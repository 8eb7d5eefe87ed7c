#!/usr/bin/env python3
"""Try the wheel for Pyodide, and the playground that runs Python in the page.

    .ci/pyodide.py FOLDER             build the wheel, and try it
    .ci/pyodide.py FOLDER WHEEL       try this one

FOLDER holds Pyodide's full distribution (a release's archive), or as much of it as `native/playground.py` names: its
program and the wheels of NumPy and a few more. In node the digests of all answers and pictures are compared with those
of all platforms; in headless Chromium the page's answers with the desktop's, bit by bit. Nothing is fetched. Needs node
and Chromium. Exit status: 0 if all is well.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from pathlib import Path

from wheel import ROOT

DIGESTS = """
import { readFileSync } from "node:fs";
const [pyodide, packages, wheel, root] = process.argv.slice(2);
const { loadPyodide } = await import(`${pyodide}/pyodide.mjs`);
const python = await loadPyodide({ indexURL: pyodide });
await python.loadPackage(packages.split(","), { messageCallback() {} });
python.unpackArchive(new Uint8Array(readFileSync(wheel)), "wheel");
python.FS.mkdirTree("/suite");
for (const name of ["same_answers", "digest"])
  python.FS.writeFile(`/suite/${name}.py`, readFileSync(`${root}/benchmarks/${name}.py`));
python.FS.writeFile("/suite/digests.json", readFileSync(`${root}/tests/native/digests.json`));
console.log(python.runPython(`
import json, sys
sys.path.insert(0, "/suite")
import digest
wanted, found = json.load(open("/suite/digests.json")), digest.digests()
wrong = sorted(kind for kind in wanted.keys() | found.keys() if wanted.get(kind) != found.get(kind))
told = "".join(f", {kind} is not" for kind in wrong)
f"{sys.version.split()[0]}: {len(wanted) - len(wrong)} digests are equal{told}"
`));
"""


def main() -> int:
    """Build if need be, and try."""
    sys.path.insert(0, str(ROOT))
    from native.playground import PACKAGES, made_wheel, write

    pyodide = Path(sys.argv[1]).resolve()
    with tempfile.TemporaryDirectory(prefix="pyodide-") as name:
        folder = Path(name)
        wheel = Path(sys.argv[2]).resolve() if len(sys.argv) > 2 else made_wheel(folder / "dist")
        (folder / "digests.mjs").write_text(DIGESTS, encoding="utf-8")
        asked = ["node", str(folder / "digests.mjs"), str(pyodide), ",".join(PACKAGES), str(wheel), str(ROOT)]
        ran = subprocess.run(asked, check=False, capture_output=True, text=True)
        told = (ran.stdout.strip() or ran.stderr[-2000:] + " is not run").splitlines()[-1]
        print(f"Python {told}", flush=True)
        write(folder / "site", wheel, str(pyodide))
        environment = os.environ | {"PLAYGROUND_FILES": str(folder / "site")}
        command = [sys.executable, "-m", "pytest", "-q", "tests/viewer/test_python_in_page.py"]
        passed = subprocess.run(command, cwd=ROOT, env=environment, check=False).returncode == 0
    fine = passed and "is not" not in told
    print(f"{wheel.name}: {'works' if fine else 'fails'}")
    return 0 if fine else 1


if __name__ == "__main__":
    sys.exit(main())
