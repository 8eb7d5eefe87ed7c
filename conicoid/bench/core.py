"""A reactor core as OpenMC's XML has it: pins in assemblies in a lattice, each universe written once."""

from __future__ import annotations

from pathlib import Path

_PITCH, _FUEL, _CLAD, _HEIGHT = 1.26, 0.41, 0.475, 200.0

_GEOMETRY = """\
<?xml version="1.0"?>
<geometry>
  <surface id="1" type="z-cylinder" coeffs="0 0 {fuel}"/>
  <surface id="2" type="z-cylinder" coeffs="0 0 {clad}"/>
  <surface id="11" type="x-plane" coeffs="-{half}" boundary="vacuum"/>
  <surface id="12" type="x-plane" coeffs="{half}" boundary="vacuum"/>
  <surface id="13" type="y-plane" coeffs="-{half}" boundary="vacuum"/>
  <surface id="14" type="y-plane" coeffs="{half}" boundary="vacuum"/>
  <surface id="15" type="z-plane" coeffs="-{high}" boundary="vacuum"/>
  <surface id="16" type="z-plane" coeffs="{high}" boundary="vacuum"/>
  <cell id="1" universe="1" material="void" name="fuel" region="-1"/>
  <cell id="2" universe="1" material="void" name="clad" region="1 -2"/>
  <cell id="3" universe="1" material="void" name="water" region="2"/>
  <lattice id="10">
    <pitch>{pitch} {pitch}</pitch><dimension>{pins} {pins}</dimension><lower_left>-{side} -{side}</lower_left>
    <universes>{of_pins}</universes>
  </lattice>
  <cell id="4" universe="2" fill="10"/>
  <lattice id="20">
    <pitch>{width} {width}</pitch><dimension>{across} {across}</dimension><lower_left>-{half} -{half}</lower_left>
    <universes>{of_assemblies}</universes>
  </lattice>
  <cell id="5" universe="0" fill="20" region="11 -12 13 -14 15 -16"/>
</geometry>
"""


def write_core(path: Path, across: int, pins: int) -> None:
    """A square core of `across` assemblies each way, each of `pins` pins each way."""
    width = pins * _PITCH
    path.write_text(
        _GEOMETRY.format(
            fuel=_FUEL, clad=_CLAD, high=_HEIGHT, pitch=_PITCH, pins=pins, across=across, width=width,
            half=across * width / 2, side=width / 2, of_pins=" ".join(["1"] * pins**2),
            of_assemblies=" ".join(["2"] * across**2),
        ),
        encoding="utf-8",
    )  # fmt: skip
