"""The renders of pictures_of_base.py: runs of the program, each in an empty folder of its own."""
import hashlib
import pathlib
import re
import subprocess
from typing import NamedTuple

SCENES = pathlib.Path(__file__).resolve().parents[1] / "scenes"
BUNDLED = {"skin_closeup": "skin_closeup/skin_closeup.json", "under_sky": "skin_closeup/under_sky.json", "backlit": "backlit/backlit.json",
           "mixed_no_subsurface": "mixed_no_subsurface/mixed_no_subsurface.json", "hard_light": "hard_light/hard_light.json",
           "dome_high_contrast": "dome_high_contrast/dome_high_contrast.json",
           "lit_from_behind": "dome_high_contrast/lit_from_behind.json", "thick_thin": "thick_thin/thick_thin.json",
           "lights": "lights/lights.json", "moving": "motion/motion.json", "sample": "sample/sample.json",
           "still_life": "still_life/still_life.json"}
NOT_AOVS = {"denoised"}  # with --denoise alone
SMALL = ("--size", "32x24")
MODES = {"reference": "subsurface=reference", "diffusion": "subsurface=diffusion", "lambert": "subsurface=lambert",
         "chiang2016": "inversion=chiang2016", "unguided": "walkGuiding=false", "small steps": "walkSphereSteps=false",
         "one bounce": "maxDepth=1", "other seed": "seed=7", "other frame": "frame=3", "box": "filter=box"}
LAYERED = {"burley2015": "energy=burley2015", "conserving": "energy=conserving", "filtered gloss": "glossyFilter=0.5",
           "filtered images": "textureFilter=1", "edges": "refineEdgeLength=4", "depth 2": "maxDepth=2"}


class Run(NamedTuple):
    """`steps`: arguments of the program, one call after the other. Their exit codes, standard output and files are compared."""
    scene: str
    mode: str
    steps: tuple
    environment: dict = {}

    @property
    def name(self):
        return f"{self.scene}/{self.mode}"

    def key(self, scene_file):
        """A digest of all that the pictures depend on, besides the program."""
        digest = hashlib.sha256(repr((self.steps, sorted(self.environment))).replace(str(scene_file.parent), "").encode())
        for file in sorted(scene_file.parent.rglob("*")):
            if file.is_file() and file.suffix not in (".py", ".md"):
                digest.update(file.name.encode() + file.read_bytes())
        return digest.hexdigest()[:20]


def aovs_of(program):
    """Those that its message about an unknown one lists."""
    done = subprocess.run([program, "render", "none.json", "-o", "a.exr", "--aov", "?"], capture_output=True, text=True)
    return [name.strip() for name in re.search(r"choose from (.*?)\.\s", done.stderr)[1].split(",")]


def with_layers(aovs):
    return [word for aov in aovs for word in ("--aov", aov.replace("primvars:NAME", "primvars:st"))]


def runs(files, aovs, oidn):
    """`files`: {scene: file} of the feature scenes and of the bundled ones; `aovs` as both programs have them."""
    every = with_layers(aovs)

    def render(scene, mode, *flags, output="a.exr", samples=("--spp", "4"), **more):
        words = ("render", str(files[scene]), "--quiet", "--threads", "2", *SMALL, *samples, *(("-o", output) if output else ()), *flags)
        return Run(scene, mode, (words,), **more)

    for scene in files:
        if scene == "lens":
            yield Run(scene, "products", (("render", str(files[scene]), "--quiet", "--threads", "2", "--spp", "4", "--allow-outside"),))
        yield render(scene, "layers", "--stats", "stats.json", *every)
    for scene in ("links", "bare", "lights"):
        yield render(scene, "formats", "-o", "a.png", "-o", "a.tif", "-o", "a.jpg", "--stats", "stats.json")
    for mode, setting in MODES.items():
        for scene in ("union", "thick"):
            yield render(scene, mode, "--set", setting, *with_layers(["error", "diffuse", "subsurface", "subsurfaceSingle"]))
    for scene in ("cloudy", "touching", "past_hidden", "grazing"):
        for mode in ("reference", "diffusion", "one bounce"):
            yield render(scene, mode, "--set", MODES[mode], *with_layers(["diffuse", "subsurface", "specular"]))
        yield render(scene, "depth 2", "--set", LAYERED["depth 2"])
    for mode, setting in LAYERED.items():
        yield render("layers", mode, "--set", setting)
    yield from of_frames(files, render, every)
    yield from of_samples(files, render, oidn)
    for scene, pixel in (("nested", "9,12,1"), ("touching", "5,14,2"), ("thick", "9,11,1"), ("cloudy", "14,12,3")):
        yield Run(scene, "pixel", (("render", str(files[scene]), *SMALL, "--spp", "4", "--pixel", pixel),))


def of_frames(files, render, every):
    yield render("nested", "crop", "--crop", "5,4,20,17", "-o", "a.png", *every)
    yield render("links", "overscan", "--crop=-4,-3,36,27", "-o", "a.tif", *every)
    yield render("moving", "no blur", "--shutter", "0:0")
    yield render("motion", "frames", "--frames", "6:10:2", "--fps", "12", "--shutter", "-0.25:0.25", "-o", "f.##.png", output="f.##.exr")
    yield render("lights", "view", "--view", "Raw", "--exposure", "1.5", output="a.png")
    yield render("nested", "studio", "--studio", "on")
    yield render("bare", "soft dome", "--studio", "off")
    yield render("nested", "other dome", "--dome", "0.2,0.5,0.9,2")


def of_samples(files, render, oidn):
    error = ("--aov", "error", "--aov", "sampleCount", "--stats", "stats.json")
    yield render("links", "adaptive", "--set", "adaptive=true", *error, samples=("--spp", "40"))
    yield render("touching", "adaptive", "--set", "adaptive=true", *error, samples=("--spp", "40"))
    yield render("thick", "adaptive to an error", "--set", "adaptive=true", "--target-error", "0.3", *error, samples=("--spp", "128"))
    yield render("union", "target error", "--target-error", "0.25", *error, samples=("--spp", "128"))
    yield render("links", "adaptive to an error", "--set", "adaptive=true", "--target-error", "0.1", *error, samples=("--spp", "128"))
    yield render("layers", "draft", "--quality", "draft")
    for scene in ("links", "mirror") if oidn else ():
        yield render(scene, "denoised", "--denoise", "-o", "a.png", environment={"ALABASTER_OIDN": str(oidn)})

    def resumed(scene, mode, first, then, *flags):
        begin = render(scene, mode, *flags, *first, "--checkpoint", "a.checkpoint", *error, output="begun.exr").steps[0]
        go_on = render(scene, mode, *flags, *then, "--checkpoint", "a.checkpoint", "--resume", *error, samples=()).steps[0]
        return Run(scene, mode, (begin, go_on))
    yield resumed("union", "resume", (), ("--spp", "7"))
    yield resumed("nested", "resume with layers", (), ("--spp", "6"), "--aov", "specular", "--aov", "depth")
    parts = [render("links", "merge", "--samples", f"{a}:{b}", "--checkpoint", f"{a}.checkpoint", "--aov", "error", "--aov", "diffuse",
                    output=None, samples=()).steps[0] for a, b in ((0, 2), (2, 5))]
    merge = ("merge", "2.checkpoint", "0.checkpoint", "-o", "merged.exr", "-o", "merged.png", "--aov", "error", "--exposure", "1", "--quiet")
    yield Run("links", "merge", (*parts, merge))
