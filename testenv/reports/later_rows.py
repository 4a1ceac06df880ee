"""Rows of reports.py for the inputs of the second and third round: subsurface scattering, hosts, materials."""
import re

import numpy as np

from measures import expect, near
from rows import Row, require_module

FURNACE = 0.02  # relative slack of means of blocks under a sky of 1


def blocks(picture, side):
    """Mean colours of the blocks of side x side pixels that are covered as a whole."""
    height, width = (size // side * side for size in picture.alpha().shape)
    split = lambda rows: rows[:height, :width].reshape(height // side, side, width // side, side, -1)  # noqa: E731
    covered = split(picture.alpha()).min((1, 3))[..., 0] > 0.999
    return split(picture.rgb()).mean((1, 3))[covered].mean(-1)


def furnace(scene, *options, side=8, slack=FURNACE):
    def check(lab):
        picture, _ = lab.render(scene, *options)
        values = blocks(picture, side)
        expect(values.size > 3, "few blocks are covered")
        near(values, np.ones_like(values), slack, scene)
    return check


def half_opaque(lab):
    picture, _ = lab.render("i_op_sss.json", "--spp", "256", "--size", "48x48")
    middle = np.zeros((48, 48), bool)
    middle[18:30, 18:30] = True
    near(picture.alpha()[middle].mean(), 0.75, 0.01, "alpha")
    near(picture.mean(middle), 3 * [0.75], 0.02, "colour")


def reciprocal_layers(lab):
    for layer in ("coat", "sheen"):
        values = [lab.render(f"{layer}_{pair}.json", "--spp", "64", "--size", "32x32")[0].mean() for pair in ("20_65", "65_20")]
        near(values[0], values[1], 0.01, layer)


def script(lab, name, *words):
    """The output of a script of the folder, which imports the module by its former name and writes archives as .json."""
    require_module(lab)
    lab.write("alabaster.py", b"from hdalabaster import *\n")
    lab.write(name, (lab.folder / name).read_bytes().replace(b'.json"', b'.alab"'))
    run = lab.python(name, *words)
    expect(run.code == 0, f"{name}: exit {run.code}: {run.text[-300:]}")
    return run.text


def moved(lab):
    text = script(lab, "move.py")
    columns = re.findall(r"^(.*): ([\d.]+|None) \(expected ~?(\d+)", text, re.M)
    expect(len(columns) + text.count("told:") == 5, text)
    for what, column, right in columns:
        expect(column != "None" and abs(float(column) - int(right)) < 1, f"{what}: {column} and not {right}")


def other_kind(lab):
    text = script(lab, "kinds.py")
    after = re.findall(r"^(?:  then|dome light).*alpha ([\d.]+) light ([\d.]+)  expected (alpha|light) 0", text, re.M)
    expect(len(after) == 7, text)
    for alpha, light, which in after:
        expect(float(alpha if which == "alpha" else light) == 0, text)


def daemon_threads(lab):
    for how in ("render", "wait", "poll", "progress"):
        script(lab, "exit.py", how)


def python_messages(lab):
    text = script(lab, "messages.py")
    told = dict(re.findall(r"^(.*?) -> (.*)$", text, re.M))
    for what, word in (("big-endian points", ">f"), ("points as text", "<U|w"), ("complex points", "Zd|complex"), ("AOV 'colour'", "color"),
                       ("indices + 2^32 (int64)", "index|indices|4294967296"), ("indices 0.75, 1.75, 2.75", "index|indices|0.75|whole"), ("width -5", "width")):
        expect(re.search(word, told.get(what, "")) and "Error" in told[what], f"{what}: {told.get(what)}")


def sets_of_many(lab):
    cost = {}
    for members in (1000, 16000):
        expect(lab.python("make.py", str(members)).code == 0, "make.py failed")
        for name in ("set", "each"):
            seconds = [lab.render(f"{name}.json", "--size", "64x64", "--spp", spp)[1].seconds for spp in ("1", "17")]
            cost[name, members] = max(seconds[1] - seconds[0], 0.01) / 16
    grows = cost["set", 16000] / cost["set", 1000]
    expect(grows < 4, f"a sample of a set of 16000 costs {grows:.1f} times that of 1000: {cost}")


def light_within(lab):
    picture, run = lab.render("b_il.json", "--spp", "64", "--size", "48x48")
    same = abs(picture.rgb()[20:28, 20:28].mean() - 1 / np.pi) < 0.02
    expect(same or run.warnings("_p") or run.warnings("light"), f"{picture.rgb()[20:28, 20:28].mean():.4f} and no message: {run.text}")


def sheets(lab):
    ratios = re.findall(r"^(.*?) +seen head on.*ratio ([\d.]+) \(expected 1\)", script(lab, "check.py"), re.M)
    expect(len(ratios) == 6, str(ratios))
    for what, ratio in ratios:
        near(float(ratio), 1, 0.002, what)


def anisotropic_metal(lab):
    lines = re.findall(r"^(bounded|conserving) (.*) least ([\d.]+) \+- ([\d.]+) at .*largest ([\d.]+) \+- ([\d.]+)", script(lab, "check.py"), re.M)
    expect(len(lines) == 10, str(lines))
    for energy, what, *numbers in lines:
        least, least_error, largest, error = map(float, numbers)
        expect(largest < 1.001 + 4 * error + 0.003 * (energy == "conserving"), f"{energy}, {what}: {largest} +- {error}")
        if energy == "conserving" and "metal" in what:
            expect(least > 0.985 - 4 * least_error, f"{what}: {least}")


def films(lab):
    rows = re.findall(r"(\d+) degrees: no film \[(.*?)\] thickness 0 \[(.*?)\] film of ior 1 \[(.*?)\] thickness 1 nm \[(.*?)\]", script(lab, "check.py"))
    expect(len(rows) == 4, str(rows))
    for angle, *values in rows:
        none, zero, no_step, thin = (np.array(v.split(), float) for v in values)
        near(zero, none, 0.005, f"thickness 0 at {angle} degrees")
        near(no_step, none, 0.005, f"ior 1 at {angle} degrees")
        near(thin, none, 0.06, f"1 nm at {angle} degrees")


def turned(lab):
    lines = re.findall(r"^(.*): mean ratio|^(.* turned: .*?) mean ratio ([\d.]+), largest pixel ([\d.]+), largest difference ([\d.]+)", script(lab, "check.py"), re.M)
    lines = [line[1:] for line in lines if line[1]]
    expect(len(lines) == 15, str(lines))
    for what, ratio, _, difference in lines:
        near(float(ratio), 1, 0.01, what)
        expect(float(difference) < 0.02, f"{what}: {difference}")


def clip_planes(lab):
    text = script(lab, "check.py")
    whole = float(re.search(r"no planes: alpha ([\d.]+)", text)[1])
    clipped = [float(value) for value in re.findall(r"alpha ([\d.]+) \(expected", text)]
    expect(len(clipped) == 3, text)
    near(np.array(clipped) / whole, (0.5, 0.5, 0.25), 0.06, "one plane, one plane, two")


def layers_of_backs(lab):
    lines = re.findall(r"^(.*?) (front|back) +opaque \[(.*?)\], diffTrans 1e-4 \[(.*?)\], specTrans 1e-4 \[(.*?)\], thin diffTrans 1e-4 \[(.*?)\]",
                       script(lab, "check.py"), re.M)
    expect(len(lines) == 8, str(lines))
    for what, side, *values in lines:
        opaque, *others = (np.array(v.split(), float) for v in values)
        for other in others:
            near(other, opaque, 0.005, f"{what} {side}")


LATER_ROWS = [
    Row("2.01 clip through a set", "01_", "blocks of 8 x 8 pixels of a furnace", "1 within 2 %",
        furnace("j_cs.json", "--spp", "64", "--size", "64x64"), "reports2"),
    Row("2.02 half opaque body", "02_", "alpha and colour of the middle", ".75 within 2 %", half_opaque, "reports2"),
    Row("2.03 glass touches a body", "03_", "blocks of 6 x 6 pixels of a furnace", "1 within 4 %",
        furnace("f_glass_half_in_sss.json", "--spp", "256", "--size", "48x48", "--max-depth", "256", side=6, slack=0.04), "reports2"),
    Row("2.04 coat and sheen", "04_", "views of 20 and 65 degrees exchanged", "equal within 1 %", reciprocal_layers, "reports2"),
    Row("2.05 set_transform", "05_", "columns", "as expected within a pixel, or told", moved, "reports2"),
    Row("2.06 another kind", "06_", "alpha, light", "0", other_kind, "reports2"),
    Row("2.07 camera within a body", "07_", "blocks of 8 x 8 pixels of a furnace", "1 within .5 %",
        furnace("i_clipone.json", "--spp", "64", "--size", "48x48", slack=0.005), "reports2"),
    Row("2.08 daemon thread", "08_", "exit code, four ways", "0", daemon_threads, "reports2"),
    Row("2.09 messages", "09_", "messages of seven calls", "an error that names what is wrong", python_messages, "reports2"),
    Row("2.10 large sets", "10_", "cost of a sample, 16000 members over 1000", "under 4", sets_of_many, "reports2"),
    Row("2.11 light within a body", "11_", "middle of the disk, messages", "1/pi, or a message", light_within, "reports2"),
    Row("3.01 sheets", "01_", "ratio of both ways through a sheet", "1 within .2 %", sheets, "reports3"),
    Row("3.02 anisotropic metal", "02_", "albedo", "at most 1.001; conserving: .985 at least", anisotropic_metal, "reports3"),
    Row("3.03 films", "03_", "thickness 0, ior 1, 1 nm", "no film within .5 %, 6 %", films, "reports3"),
    Row("3.04 turned", "04_", "mean and pixels of turned scenes", "equal within 1 %, .02", turned, "reports3"),
    Row("3.05 clip planes", "05_", "alpha", "a half, a quarter", clip_planes, "reports3"),
    Row("3.06 backs of sheets", "06_", "colours", "as opaque within .5 %", layers_of_backs, "reports3"),
]
