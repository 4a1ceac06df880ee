"""Rows that are treated otherwise. Scenes and checks as matrix.py --list prints them; scenes by regular expressions."""
import pathlib
import re
from typing import NamedTuple

MOST_EXEMPT = 0.05  # of all rows


class Exemption(NamedTuple):
    scene: str
    check: str
    bound: float  # in units of the rule
    reason: str  # as documented, and where

    def covers(self, scene, check):
        return check == self.check and re.search(self.scene, scene) is not None


LOSSLESS_BUMPS = "^(?!.*(coat|sheen|specular)).*normal map"  # layers and rough facets may keep more light than bumps lose

WALLS_OF_HOLLOWS = ("the far wall of a clear body with holes is a thin sheet from inside and a solid from outside "
                    "(delegate/manual/artists.md, Holes and opacity)")

# Rows that need not hold. A row beyond the bound fails, and one that holds is printed as stale.
EXEMPT = [
    Exemption(LOSSLESS_BUMPS, "furnace, viewer", 4.0,
              "what a mapped normal sends below the surface is lost (delegate/manual/artists.md, Textures)"),
    Exemption(LOSSLESS_BUMPS, "furnace, light", 4.0,
              "what a mapped normal sends below the surface is lost (delegate/manual/artists.md, Textures)"),
    Exemption(r"^opaque body \+ fibre sheen \+ clearcoat$", "furnace, as Lambert", 2.0,
              "subsurface does not yield to clearcoat as diffuse does (delegate/manual/artists.md, Energy)"),
    Exemption(r"^opaque body \+ fibre sheen \+ inner shell$", "furnace, as Lambert", 2.5,
              "walks cross the cavity, whose fibres keep light; Lambert's law sends none there (delegate/manual/artists.md, The layers of a material)"),
    Exemption(r"^glass \+ opacity \+ touching$", "reciprocity", 4.0, WALLS_OF_HOLLOWS),
    Exemption(r"^(glass|cloudy body) \+ opacity \+ pyramid$", "reciprocity", 80.0, WALLS_OF_HOLLOWS),
    Exemption(r"^opaque body \+ cloudy body \+ opacity$", "furnace, light", 10.0,
              "walks in one body pass through others (delegate/manual/artists.md, Bodies that scatter as one)"),
]

# Rows that fail and should not, a scene and a check in a line. They are run and printed, and do not fail the run.
OPEN = {tuple(line.split(": ", 1)) for line in (pathlib.Path(__file__).parent / "open_rows.txt").read_text().splitlines()}

# The rows of --quick: (scene, checks).
QUICK = {
    "opaque body": ("furnace, viewer", "limit of small distances", "walk and reference", "AOVs add up", "crops and threads"),
    "cloudy body": ("furnace, viewer", "AOVs add up", "crops and threads"),
    "glass": ("furnace, viewer", "crops and threads"),
    "opaque body + opacity": ("furnace, viewer", "limit of small distances", "AOVs add up", "crops and threads"),
    "opaque body + coat": ("furnace, as Lambert", "reciprocity", "limit of small distances", "walk and reference", "AOVs add up"),
    "opaque body + stained coat": ("furnace, as Lambert", "reciprocity", "limit of small distances", "walk and reference", "AOVs add up"),
    "opaque body + fibre sheen": ("furnace, as Lambert", "reciprocity", "limit of small distances", "AOVs add up"),
    "opaque body + clearcoat": ("furnace, as Lambert",),
    "opaque body + touching": ("furnace, viewer", "AOVs add up", "crops and threads"),
    "opaque body + inner shell": ("furnace, viewer",),
    "opaque body + cut": ("furnace, viewer",),
    "opaque body + camera inside": ("furnace, viewer", "crops and threads"),
    "opaque body + coat + camera inside": ("furnace, viewer",),
    "opaque body + face to face": ("furnace, viewer",),
    "opaque body + shear": ("furnace, viewer",),
    "opaque body + motion": ("furnace, viewer", "crops and threads"),
    "opaque body + union + cut": ("furnace, viewer",),
    "opaque body + glass": ("furnace, viewer",),
    "opaque body + below glass": ("furnace, light",),
    "opaque body + glass on its face": ("limit of small distances",),
    "cloudy body + opacity": ("furnace, viewer",),
    "cloudy body + opacity + union": ("furnace, viewer",),
    "glass + face to face": ("furnace, viewer",),
    "opaque body + union": ("furnace, viewer", "crops and threads", "limit of small distances"),
    "cloudy body + camera inside": ("furnace, viewer",),
    "cloudy body + ball within": ("furnace, viewer", "reciprocity", "content as faces", "content of the same medium", "AOVs add up",
                                  "crops and threads"),
    "cloudy body + label + ball within": ("content of the same medium",),
    "opaque body + weight": ("furnace, viewer", "limit of small distances", "walk and reference", "AOVs add up"),
    "opaque body + weight map": ("furnace, viewer", "furnace, light", "reciprocity", "AOVs add up", "crops and threads"),
    "sheet + thin + diffTrans + coat": ("reciprocity", "furnace, viewer, bounded"),
    "sheet + thin + diffTrans + sheen": ("reciprocity", "furnace, light"),
    "sheet + diffTrans + coat": ("a feature that vanishes", "reciprocity"),
    "sheet + film": ("a feature that vanishes",),
    "metal + anisotropic": ("furnace, viewer", "turned as a whole"),
    "sheet + anisotropic 1.0 + roughness 0.1": ("furnace, viewer, bounded",),
}
