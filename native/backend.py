"""hatchling as `pyproject.toml` names it, but an editable install requires no compilers.

hatchling does not inform the hook which kind of build will follow when it reads the requirements.
"""

from __future__ import annotations

import os
from typing import Any

from hatchling import build
from hatchling.build import *  # noqa: F403


def get_requires_for_build_editable(config_settings: dict[str, Any] | None = None) -> list[str]:
    """Return the requirements of an editable install beside hatchling: no kernels are built for it."""
    os.environ["CONICOID_KERNELS"] = "none"  # this process does nothing else
    return build.get_requires_for_build_editable(config_settings)
