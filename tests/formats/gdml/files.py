"""GDML texts, and scenes of them."""

import conicoid as co

HEAD = '<?xml version="1.0"?>\n<gdml xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance">\n'
MATERIALS = """<materials>
<material name="air" state="gas"><D value="0.0012"/><atom value="14"/></material>
<material name="iron" Z="26"><D value="7.87" unit="g/cm3"/><atom value="55.8"/></material>
</materials>
"""


def text_of(solids: str, structure: str, define: str = "", materials: str = MATERIALS, world: str = "world") -> str:
    setup = f'<setup name="Default" version="1.0"><world ref="{world}"/></setup>'
    return (
        f"{HEAD}<define>{define}</define>\n{materials}<solids>\n{solids}\n</solids>\n"
        f"<structure>\n{structure}\n</structure>\n{setup}\n</gdml>\n"
    )


def volume(name: str, solid: str, inside: str = "", material: str = "iron") -> str:
    return f'<volume name="{name}"><materialref ref="{material}"/><solidref ref="{solid}"/>{inside}</volume>'


def placed(volume: str, inside: str = "", attributes: str = "") -> str:
    return f'<physvol {attributes}><volumeref ref="{volume}"/>{inside}</physvol>'


def scene_of(folder, text: str, **options) -> co.Scene:
    path = folder / "a.gdml"
    path.write_text(text, encoding="utf-8")
    return co.load(path, **options)


def solid_scene(folder, solids: str, name: str, define: str = "") -> co.Scene:
    """Return a scene of one solid."""
    return scene_of(folder, text_of(solids, volume("world", name), define))
