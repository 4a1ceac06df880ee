"""A user's story in the window, chapter by chapter, and the pixels and states that must follow."""
import json
import math

import target_scene

checks = 0
MIDDLES = {"red": (0.42, 0.36), "green": (0.58, 0.36), "blue": (0.42, 0.64), "wall": (0.58, 0.64)}  # in the picture


class Picture:
    """A PPM of eight bits."""

    def __init__(self, data):
        kind, size, top, self.bytes = data.split(b"\n", 3)
        assert kind == b"P6" and top == b"255"
        self.width, self.height = map(int, size.split())

    def at(self, x, y):
        first = 3 * (y * self.width + x)
        return tuple(self.bytes[first:first + 3])

    def share(self, place):
        """The colour at a place from 0 to 1, y down."""
        return self.at(int(place[0] * self.width), int(place[1] * self.height))

    def find(self, part):
        """Where `part` stands in this picture, or None. Files are dithered and windows are not: levels may differ by one."""
        def alike(x, y, step):
            return all(abs(a - b) <= 1 for j in range(0, part.height, step) for i in range(0, part.width, step)
                       for a, b in zip(self.at(x + i, y + j), part.at(i, j)))

        places = ((x, y) for y in range(self.height - part.height + 1) for x in range(self.width - part.width + 1))
        return next((place for place in places if alike(*place, 37) and alike(*place, 1)), None)

    def differs(self, other):
        """The share of pixels that differ."""
        pairs = range(0, len(self.bytes), 3)
        return sum(self.bytes[i:i + 3] != other.bytes[i:i + 3] for i in pairs) / len(pairs)


def check(true, text):
    global checks
    checks += 1
    if not true:
        raise SystemExit("error: " + text)


def check_near(values, wanted, tolerance, text):
    check(len(values) == len(wanted) and all(abs(a - b) <= tolerance for a, b in zip(values, wanted)),
          f"{text}: {tuple(values)} instead of {tuple(wanted)}")


def srgb(linear):
    encoded = 12.92 * linear if linear <= 0.0031308 else 1.055 * linear ** (1 / 2.4) - 0.055
    return 255 * min(1, max(0, encoded))


def save_picture(name):
    return ["press Save", f'type "picture file" {name}', 'press "Save picture"']


def save_description(name):
    return ["press Save", f'type "description file" {name}', 'press "Save description"']


PLAIN_VIEW = ['choose View "Un-tone-mapped"', "wait converged"]


def tell(window):
    for chapter in (picture_is_right, background_is_black, drags, lenses, edits, options_of_render, layers_and_display, pausing, denoising, saving, wipes,
                    lights, reloads, faults_of_scripts):
        before = checks
        chapter(window, target_scene.write(window.folder))
        print(f"{chapter.__name__.replace('_', ' ')}: {checks - before} checks", flush=True)


def picture_is_right(window, scene):
    first, = window.play(scene, ["size 1000 640", "wait converged", *PLAIN_VIEW, *save_picture("shown.png"),
                                 "press Material", "screenshot window.ppm", "state"])
    shown, screenshot = window.picture("shown.png"), window.picture("window.ppm")
    check_near([screenshot.width, screenshot.height], [1000, 640], 0, "the window's size")
    check_near([shown.width, shown.height], first["size"], 0, "the picture's size")
    check(abs(shown.width / shown.height - 4 / 3) < 0.01, "the picture has not the shape of the scene's frame")
    check(screenshot.find(shown) is not None, "the window shows other pixels than it saves")
    for name, (_, _, color) in target_scene.SQUARES.items():
        # A dome of radiance 1 over a matte square; Disney's diffuse lobe differs from Lambert's by a few per cent.
        check_near(shown.share(MIDDLES[name]), [srgb(c) for c in color], 14, name)
    done = window.run("render", scene, "-o", "rendered.png", "--size", f"{shown.width}x{shown.height}",
                      "--view", "Un-tone-mapped", "--quiet")
    check(done.returncode == 0, done.stderr)
    check(shown.bytes == window.picture("rendered.png").bytes, "alabaster render makes other pixels")


def background_is_black(window, _):
    window.play(target_scene.write(window.folder, wall=False), ["size 1000 640", "wait converged", "screenshot window.ppm"])
    screenshot = window.picture("window.ppm")
    check_near(screenshot.at(380, 420), (0, 0, 0), 0, "what has no alpha is shown over black")


def place(state):
    return [state["camera"][i] for i in (12, 13, 14)]


def back(state):
    return [state["camera"][i] for i in (8, 9, 10)]


def drags(window, scene):
    first, orbited, panned, zoomed, wheeled, returned = window.play(scene, [
        "size 1000 640", "wait converged", "screenshot first.ppm", "state",
        "drag left 0.45 0.45 0.55 0.40", "wait converged", "screenshot orbited.ppm", "state",
        "drag middle 0.4 0.4 0.5 0.3", "wait converged", "state",
        "drag right 0.45 0.45 0.45 0.35", "wait converged", "state",
        "wheel 0.45 0.45 2", "wait converged", "state",
        "key R", "wait converged", "screenshot returned.ppm", "state"])
    check_near(place(first), (0, 0, 5), 1e-6, "the scene's camera")
    check(place(orbited)[0] < -0.5 and place(orbited)[1] < -0.2,
          f"a drag to the right and upwards moves the camera to {place(orbited)}, not to the left and downwards")
    # The pivot is the point of the red square that was pressed.
    across, sight = 0.48 * 4 / 3 * 5, 0.48 * 5
    pivot = ((0.45 - 0.5) * across, (0.5 - 0.45) * sight, 0)
    check_near([math.dist(place(first), pivot)], [math.dist(place(orbited), pivot)], 0.02, "distance to the pivot")
    check_near(back(panned), back(orbited), 1e-9, "a pan does not turn")
    check(math.dist(place(panned), place(orbited)) > 0.3, "a pan moves")
    nearer = [math.dist(place(s), pivot) for s in (panned, zoomed, wheeled)]
    check(nearer[1] < 0.95 * nearer[0] and nearer[2] < 0.95 * nearer[1], f"zooms do not come nearer: {nearer}")
    check_near(place(returned), place(first), 0, "key R")
    pictures = [window.picture(name) for name in ("first.ppm", "orbited.ppm")]
    check(pictures[0].differs(pictures[1]) > 0.02, "a drag does not change the picture")


def lenses(window, scene):
    """Twice the focal length shows everything twice as large."""
    near, = window.play(scene, [
        "size 1000 640", "wait converged", *PLAIN_VIEW, *save_picture("near.png"), "press Camera", "type focalLength 100",
        "wait converged", *save_picture("far.png"), *save_description("lens.json"), "state"])
    narrow, wide = window.picture("far.png"), window.picture("near.png")
    for x, y in ((0.2, 0.2), (0.8, 0.2), (0.2, 0.8), (0.9, 0.9), (0.45, 0.45)):
        check_near(narrow.share((x, y)), wide.share((0.25 + x / 2, 0.25 + y / 2)), 12, f"place {x}, {y}")
    done = window.run("render", "lens.json", "-o", "again.png", "--size", "{}x{}".format(*near["size"]), "--view", "Un-tone-mapped",
                      "--quiet")
    check(done.returncode == 0, done.stderr)
    check(window.picture("again.png").bytes == narrow.bytes, "the saved lens is another one")


def edits(window, scene):
    picked, edited, typed, light = window.play(scene, [
        "size 1000 640", "wait converged", *PLAIN_VIEW, *save_picture("before.png"),
        "click {} {}".format(*MIDDLES["green"]), "state",
        "slide baseColor.r 1", "wait converged", *save_picture("slid.png"), "state",
        "press Material", "type baseColor.b 0.5", "wait converged", *save_picture("typed.png"), "state",
        "press Light", "type intensity 0.25", "wait converged", *save_picture("light.png"), "state"])
    check(picked["picked"]["mesh"].endswith("green/0"), f"picked {picked['picked']}")
    check(picked["picked"]["material"].endswith("green"), f"picked {picked['picked']}")
    check(picked["picked"]["face"] in (0, 1), f"picked {picked['picked']}")
    before, slid, final, dim = (window.picture(f"{n}.png") for n in ("before", "slid", "typed", "light"))
    check_near(before.share(MIDDLES["green"]), [srgb(c) for c in (0.05, 0.8, 0.05)], 14, "before the edit")
    check_near(slid.share(MIDDLES["green"]), [srgb(c) for c in (1, 0.8, 0.05)], 14, "after the slider")
    check_near(final.share(MIDDLES["green"]), [srgb(c) for c in (1, 0.8, 0.5)], 14, "after the typed number")
    for other in ("red", "blue"):
        check_near(slid.share(MIDDLES[other]), before.share(MIDDLES[other]), 3, f"{other} stays")
    check_near(dim.share(MIDDLES["blue"]), [srgb(0.25 * c) for c in (0.05, 0.05, 0.8)], 10, "a light of a quarter")
    check(edited["samples"] == typed["samples"] == light["samples"] == 4, "each edit is rendered to its end")


def options_of_render(window, scene):
    """The options of a scene mean what they mean to alabaster render, and are in the description that is saved."""
    options = ["--set", "materials/red.baseColor=[0.1,0.2,0.9]", "--set", "samples=6", "--dome", "0.5,0.4,0.3,2", "--time", "1.5",
               "--scene", "0", "--camera", "camera"]
    state, = window.play(scene, ["size 1000 640", "wait converged", *save_picture("shown.png"), *save_description("kept.json"), "state"],
                         *options)
    check(state["samples"] == 6, f"{state['samples']} samples")
    check(any("every time shows the same" in text for text in state["messages"]), f"no warning of --time: {state['messages']}")
    size = ["--size", "{}x{}".format(*state["size"]), "--quiet"]
    for arguments in ([scene, *options], ["kept.json"]):
        done = window.run("render", *arguments, "-o", "again.png", *size)
        check(done.returncode == 0, done.stderr)
        check(window.picture("again.png").bytes == window.picture("shown.png").bytes, f"render {arguments} makes other pixels")


def layers_and_display(window, scene):
    states = window.play(scene, [
        "size 1000 640", "wait converged", *PLAIN_VIEW, "choose AOV normal", "wait converged", "screenshot normal.ppm", "state",
        "choose AOV primId", "wait converged", "screenshot ids.ppm", "choose AOV cameraDepth", "wait converged",
        "screenshot depth.ppm", "choose AOV color", 'choose View "Raw"', "wait converged", *save_picture("raw.png"),
        "type Exposure -1", "wait seconds 0.5", *save_picture("darker.png"), "press Material", "screenshot darker.ppm", "state"])
    check(states[0]["aov"] == "normal" and states[1]["aov"] == "color" and states[1]["view"] == "Raw", str(states))
    corner = window.picture("darker.ppm").find(window.picture("darker.png"))
    check(corner is not None, "the window shows another exposure than it saves")
    width, height = states[1]["size"]

    def seen(name, square):
        x, y = MIDDLES[square]
        return window.picture(name).at(corner[0] + int(x * width), corner[1] + int(y * height))

    check_near(seen("normal.ppm", "red"), (128, 128, 255), 1, "a square that faces the camera")
    ids = {seen("ids.ppm", square) for square in MIDDLES}
    check(len(ids) == 4, f"each object has a colour of its own: {ids}")
    check(max(seen("depth.ppm", "red")) < 128, "what is near is dark")
    raw, darker = window.picture("raw.png").share(MIDDLES["red"]), window.picture("darker.png").share(MIDDLES["red"])
    check_near(raw, [255 * c for c in target_scene.SQUARES["red"][2]], 14, "view Raw")
    check_near(darker, [c / 2 for c in raw], 1, "a stop less")
    check(states[1]["exposure"] == -1, str(states[1]))


def pausing(window, scene):
    paused, later, going = window.play(target_scene.write(window.folder, samples=100000), [
        "size 1000 640", "wait samples 40", "key space", "wait seconds 0.5", "state", "wait seconds 1", "state",
        "press Continue", "wait seconds 0.3", "state"])
    check(paused["paused"] and later["paused"] and not going["paused"], "the space bar pauses")
    check(later["samples"] == paused["samples"], "nothing is rendered while it is paused")
    check(going["samples"] >= later["samples"] >= 40, "it goes on where it was")
    check(0 < going["noise"] < 0.2, f"the noise is {going['noise']} after 40 samples, while the render goes on")


def denoising(window, scene):
    if "ALABASTER_OIDN" not in window.environment:
        print("denoising: not tested, because no library was named (--oidn)")
        return
    window.environment["FAKE_OIDN"] = "color alone"  # twice the colour
    whole, half = window.play(scene, [
        "size 1000 640", "wait converged", *PLAIN_VIEW, 'choose View "Raw"', "type Exposure -1", "press Denoised", "wait converged",
        "wait seconds 1", "screenshot denoised.ppm", "state", 'press "Side by side"', "wait converged", "wait seconds 1",
        "screenshot both.ppm", "key w", "press Rendered", "wait seconds 1", "screenshot kept.ppm", "key w", "wait seconds 1", *save_picture("plain.png"), "press Material",
        "screenshot plain.ppm", "state"])
    plain, shown, both, kept = (window.picture(f"{n}.ppm") for n in ("plain", "denoised", "both", "kept"))
    x, y = plain.find(window.picture("plain.png"))
    width, height = half["size"]
    red = (x + int(MIDDLES["red"][0] * width), y + int(MIDDLES["red"][1] * height))
    green = (x + int(MIDDLES["green"][0] * width), y + int(MIDDLES["green"][1] * height))
    twice = [min(255, 2 * c) for c in plain.at(*green)]
    check_near(shown.at(*green), twice, 2, "the denoised picture")
    check_near(both.at(*green), twice, 2, "right of the divider")
    check_near(both.at(*red), plain.at(*red), 0, "left of the divider")
    check_near(kept.at(*red), [min(255, 2 * c) for c in plain.at(*red)], 2, "a denoised picture that was kept")
    check_near(kept.at(*green), plain.at(*green), 0, "beside the present one as rendered")
    for options in ([], ["--set", "targetError=0.0001"]):
        paused, going = window.play(target_scene.write(window.folder, samples=100000), [
            "size 1000 640", "press Denoised", "wait samples 40", "key space", "wait seconds 1", "state", "press Continue",
            "wait covered", "state"], *options)
        check(paused["paused"] and paused["denoiser"] != "", f"a pause shows what is there denoised: {paused}")
        check(going["samples"] >= paused["samples"] >= 40, f"{going['samples']} samples after a pause at {paused['samples']} {options}")


def saving(window, scene):
    before, = window.play(scene, [
        "size 1000 640", "wait converged", "drag left 0.45 0.45 0.58 0.38", "wait converged",
        "click 0.5 0.45", "press Material", "type roughness 0.2", "type scatterDistance.g 300", "press Light", "type color.b 0.4",
        "press Render", "type samples 7", "choose subsurface diffusion", "wait converged",
        *save_picture("shown.png"), *save_description("changed.json"), "state"])
    done = window.run("render", "changed.json", "-o", "again.png", "--size", "{}x{}".format(*before["size"]), "--quiet")
    check(done.returncode == 0, done.stderr)
    shown, again = window.picture("shown.png"), window.picture("again.png")
    check(shown.bytes == again.bytes, f"the saved description renders {100 * shown.differs(again):.1f} % other pixels")
    untouched, = window.play(scene, ["size 1000 640", "wait converged", *save_picture("first.png"), "state"])
    check(window.picture("first.png").differs(shown) > 0.1, "the edits do not show")
    check(untouched["messages"] == [], str(untouched["messages"]))
    refused, = window.play(scene, ["wait covered", *save_description("target.json"), *save_picture("target.gltf"), "state"])
    check(len(refused["messages"]) == 2 and "choose another name" in refused["messages"][0], str(refused["messages"]))


def wipes(window, scene):
    """Key W keeps the look; a line that the mouse drags divides it from the one that is edited. Both follow the display."""
    edited, moved, swapped, dropped = window.play(scene, [
        "size 1000 640", "wait converged", *PLAIN_VIEW, 'choose View "Raw"', *save_picture("first.png"), "press Light",
        "screenshot first.ppm", "key w", "type intensity 0.25", "wait converged", "wait seconds 0.5", "screenshot both.ppm", "state",
        "drag left 0.5 0.9 0.7 0.9", "wait seconds 0.5", "screenshot dragged.ppm",
        "type Exposure -1", "wait seconds 0.5", "screenshot darker.ppm", "type Exposure 0",
        "drag left 0.3 0.9 0.35 0.9", "wait converged", "state", "key R", "wait converged",
        "key x", "wait converged", "wait seconds 0.5", *save_picture("swapped.png"), "press Light", "screenshot swapped.ppm", "state",
        "key w", "wait converged", "wait seconds 0.5", "screenshot dropped.ppm", "state"])
    first = window.picture("first.ppm")
    x, y = first.find(window.picture("first.png"))
    width, height = edited["size"]

    def seen(name, square):
        place = MIDDLES[square]
        return window.picture(name).at(x + int(place[0] * width), y + int(place[1] * height))

    quarter = [c / 4 for c in seen("first.ppm", "green")]
    check(edited["kept"] == {"samples": 4, "isFraming": True}, f"kept {edited['kept']}")
    check_near(seen("both.ppm", "red"), seen("first.ppm", "red"), 0, "left of the line is what was kept")
    check_near(seen("both.ppm", "green"), quarter, 1, "right of the line is what was edited")
    check_near(seen("dragged.ppm", "green"), seen("first.ppm", "green"), 0, "the line was dragged beyond it")
    check_near(seen("darker.ppm", "green"), [c / 2 for c in seen("first.ppm", "green")], 1, "what was kept follows the exposure")
    check(not moved["kept"]["isFraming"], "a drag of the camera leaves what was kept behind")
    check(swapped["kept"]["isFraming"], "key R")
    check(window.picture("swapped.png").bytes == window.picture("first.png").bytes, "key X does not go back to the kept look")
    check_near(seen("swapped.ppm", "green"), quarter, 1, "and keeps the present one")
    check_near(seen("dropped.ppm", "red"), seen("first.ppm", "red"), 0, "key W again shows one picture")
    check("kept" not in dropped, str(dropped))


def saved_lights(window, name):
    """By name: the last entry that a saved description has."""
    return {light.get("name", light.get("match")): light for light in json.loads((window.folder / name).read_text())["lights"]}


def lights(window, scene):
    """A light is added, placed by its highlight, aimed, moved, reset and removed; so is one of the scene's, but for the last."""
    document = json.loads(scene.read_text())
    document["lights"] = [{"name": "sky", "type": "domeLight", "intensity": 0.02},
                          {"name": "lamp", "type": "rectLight", "position": [1, 1, 3], "target": [0, 0, 0], "intensity": 1}]
    scene.write_text(json.dumps(document))
    spot = (0.56, 0.42)
    state, = window.play(scene, [
        "size 1000 640", "wait converged", *PLAIN_VIEW, *save_picture("first.png"), "click {} {}".format(*MIDDLES["green"]),
        "press Material", "type specular 1", "type roughness 0.15",
        "press Light", "choose add sphereLight", "type radius 50", "type intensity 9000", "wait converged", *save_description("added.json"),
        "press Light", "press Highlight", "wait converged", "click {} {}".format(*spot), "wait converged",
        *save_picture("highlight.png"), *save_description("highlight.json"),
        "press Light", "press Aim", "click {} {}".format(*MIDDLES["blue"]), *save_description("aimed.json"),
        "press Light", "press Move", "drag left 0.4 0.3 0.5 0.3", "choose light /lights/lamp", "press Aim",
        "click {} {}".format(*MIDDLES["red"]), "type position.g 1700", "wait converged",
        "press Save", "wait converged", *save_picture("moved.png"), *save_description("moved.json"),
        "press Light", 'press "reset position"', "choose light /lights/sphere", 'press "reset position"', *save_description("reset.json"),
        "press Light", "press Remove", "press Material", 'press "reset specular"', 'press "reset roughness"', "wait converged",
        *save_picture("removed.png"), *save_description("removed.json"), "state"])
    check(state["messages"] == [], str(state["messages"]))
    added, highlight, aimed, moved, reset, removed = (
        saved_lights(window, f"{n}.json") for n in ("added", "highlight", "aimed", "moved", "reset", "removed"))

    def at(light):
        return light["transform"][12:15]

    across, sight = 0.48 * 4 / 3 * 5, 0.48 * 5  # where z is 0

    def point(x, y):
        return (x - 0.5) * across, (0.5 - y) * sight, 0

    def way(start, end):
        return [(b - a) / math.dist(start, end) for a, b in zip(start, end)]

    px, py, _ = point(*spot)
    check(at(added["sphere"])[0] < -1 and at(added["sphere"])[1] > 1, f"a new light stands at {at(added['sphere'])}, not at the upper left")
    check_near(way(point(*spot), at(highlight["sphere"])), way((0, 0, 0), (px, py, 5)), 0.01, "the mirrored direction of the eye")
    shown = window.picture("highlight.png")
    blues = [(shown.at(i, j)[2], i, j) for j in range(int(0.2 * shown.height), shown.height // 2) for i in range(shown.width // 2, int(0.7 * shown.width))]
    top = max(blues)[0]
    bright = [(i / shown.width, j / shown.height) for blue, i, j in blues if blue > 0.8 * top]
    check_near([sum(p[k] for p in bright) / len(bright) for k in (0, 1)], spot, 0.02, "the highlight in the picture")
    back = [-c for c in aimed["sphere"]["transform"][8:11]]
    check_near(back, way(at(aimed["sphere"]), point(*MIDDLES["blue"])), 0.01, "what it is aimed at")
    check_near(at(aimed["sphere"]), at(highlight["sphere"]), 1e-9, "its place")
    check(at(moved["sphere"])[0] > at(aimed["sphere"])[0] + 0.1, f"a drag to the right moves it from {at(aimed['sphere'])} to {at(moved['sphere'])}")
    check_near(at(moved["sphere"])[1:], at(aimed["sphere"])[1:], 1e-6, "upwards and backwards")
    lamp = moved["/lights/lamp"]["transform"]
    check_near(lamp[12:15], (1, 1.7, 3), 1e-6, "the number that was typed")
    check_near([-c for c in lamp[8:11]], way((1, 1, 3), point(*MIDDLES["red"])), 0.01, "what the scene's light is aimed at")
    done = window.run("render", "moved.json", "-o", "again.png", "--size", "{}x{}".format(*state["size"]), "--view", "Un-tone-mapped", "--quiet")
    check(done.returncode == 0, done.stderr)
    check(window.picture("again.png").bytes == window.picture("moved.png").bytes, "the saved lights are others")
    check_near(reset["sphere"]["transform"], added["sphere"]["transform"], 0, "a reset")
    check("/lights/lamp" not in reset, str(reset))
    check(sorted(removed) == ["lamp", "sky"], f"lights {sorted(removed)} are left")
    check(window.picture("removed.png").bytes == window.picture("first.png").bytes, "what was removed or reset is still seen")


def reloads(window, scene):
    """A changed file is offered, and loaded with the edits that its prims still have; a broken one leaves the scene as it is."""
    document = json.loads(scene.read_text())
    del document["materials"]
    scene.write_text(json.dumps(document))
    whole = (window.folder / "target.gltf").read_text()
    (window.folder / "whole.gltf").write_text(whole)
    changed = json.loads(whole)
    changed["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"] = [0.05, 0.05, 0.8, 1]
    changed["materials"][2]["name"] = "azure"
    (window.folder / "changed.gltf").write_text(json.dumps(changed))
    (window.folder / "broken.gltf").write_text(whole[:len(whole) // 2])
    before, offered, loaded, broken, again = window.play(scene, [
        "size 1000 640", "wait converged", *PLAIN_VIEW, "drag left 0.45 0.45 0.46 0.45", "wait converged",
        "click {} {}".format(*MIDDLES["green"]), "type baseColor.r 1", "press Save", "click {} {}".format(*MIDDLES["blue"]),
        "type baseColor.g 0.5", "wait converged", *save_picture("before.png"), "state",
        "copy changed.gltf target.gltf", "wait seconds 1", "state", "press Reload", "wait converged", *save_picture("loaded.png"), "state",
        "copy broken.gltf target.gltf", "wait seconds 1", "key l", "wait converged", *save_picture("broken.png"), "state",
        "press Save", 'press "reload by itself"', "copy whole.gltf target.gltf", "wait seconds 3", "wait converged",
        *save_picture("again.png"), *save_description("kept.json"), "state"])
    check(not before["filesChanged"] and offered["filesChanged"] and not loaded["filesChanged"], "a changed file is offered once")
    old, new = window.picture("before.png"), window.picture("loaded.png")
    check_near(new.share(MIDDLES["green"]), old.share(MIDDLES["green"]), 2, "an edit stays")
    check(new.share(MIDDLES["red"])[2] > 2 * new.share(MIDDLES["red"])[0], f"the file has another colour: {new.share(MIDDLES['red'])}")
    check(new.share(MIDDLES["blue"])[1] < old.share(MIDDLES["blue"])[1] - 40, "the edit of a material that is gone is not seen")
    check(before["camera"] == loaded["camera"] == again["camera"], "the camera stays")
    check(any("2_blue" in text and "waits" in text for text in loaded["messages"]), f"no message of the edit that waits: {loaded['messages']}")
    check(window.picture("broken.png").bytes == new.bytes, "a broken file changes the picture")
    check(any("target.gltf" in text for text in broken["messages"]) and "stays" in broken["messages"][-1], str(broken["messages"]))
    check_near(window.picture("again.png").share(MIDDLES["red"]), old.share(MIDDLES["red"]), 2, "the file as it was is loaded by itself")
    check_near(window.picture("again.png").share(MIDDLES["blue"]), old.share(MIDDLES["blue"]), 2, "and the edit of the material that was gone")
    done = window.run("render", "kept.json", "-o", "rendered.png", "--size", "{}x{}".format(*again["size"]), "--view", "Un-tone-mapped", "--quiet")
    check(done.returncode == 0, done.stderr)
    check(window.picture("rendered.png").bytes == window.picture("again.png").bytes, "the saved description is another scene")


def dense_screens(plain, dense):
    """Where the desktop asks for twice the dots, letters and widgets are twice as large, and pixels stay pixels."""
    before, scene = checks, target_scene.write(plain.folder)
    states, corners = [], []
    for window, size in ((plain, "1000 640"), (dense, "2000 1280")):
        state, = window.play(scene, ["size " + size, "wait converged", *PLAIN_VIEW, *save_picture("shown.png"), "press Render",
                                     "screenshot window.ppm", "click {} {}".format(*MIDDLES["green"]), "state"])
        check(state["picked"]["mesh"].endswith("green/0"), f"picked {state['picked']}")
        states.append(state)
        corners.append(window.picture("window.ppm").find(window.picture("shown.png")))
        check(corners[-1] is not None, f"the window shows other pixels than it saves, at scale {state['scale']}")
    check([state["scale"] for state in states] == [[1, 1], [2, 1]], f"scales {[state['scale'] for state in states]}")
    check_near(states[1]["size"], [2 * n for n in states[0]["size"]], 4, "pixels of the picture")
    check_near(corners[1], [2 * n for n in corners[0]], 4, "the place of the picture, below a toolbar twice as high")
    opened, = dense.play(scene, ["wait covered", "state"])
    check_near(opened["size"], [2 * n for n in plain.play(scene, ["wait covered", "state"])[0]["size"]], 4, "the window at first")
    print(f"dense screens: {checks - before} checks", flush=True)


def faults_of_scripts(window, scene):
    (window.folder / "lost.txt").write_text("wait covered\npress Nothing\n")
    lost = window.run("lost.txt", scene, program=window.player)
    check(lost.returncode == 4 and "line 2: there is no widget 'Nothing'" in lost.stderr, f"{lost.returncode}: {lost.stderr}")


def refusals(window):
    """Bad words, bad files and no display are told in the terminal, by the program's exit codes."""
    scene = target_scene.write(window.folder)
    (window.folder / "bad.txt").write_text("fly\n")
    (window.folder / "bad.json").write_text('{"gltf": [{"file": "target.gltf"}], "lihgts": []}')
    for arguments, code, text in (
            ([scene], 4, "could not be opened"), (["missing.json"], 3, "missing.json"), (["bad.json"], 3, "lights"),
            ([], 2, "SCENE is required"), (["--help"], 0, "--camera"),
            ([scene, "--ocio", "missing.ocio"], 3, "missing.ocio"), ([scene, "--fly"], 2, "--fly"),
            ([scene, "--time", "soon"], 2, "'soon' is not a time"), ([scene, "--camera", "lost"], 2, "camera lost"),
            ([scene, "--set", "materials/red.rouhgness=1"], 2, "roughness"), ([scene, "--variant", "lost"], 2, "lost")):
        done = window.run("view", *arguments)
        check(done.returncode == code and text in done.stdout + done.stderr,
              f"view {arguments}: exit code {done.returncode} instead of {code}, {done.stdout}{done.stderr}")
    for script, text in (("bad.txt", "line 1: there is no action 'fly'"), ("missing.txt", "cannot be read"),
                         ("/dev/zero", "cannot be read")):
        done = window.run(script, scene, program=window.player)
        check(done.returncode == 2 and text in done.stderr, f"script {script}: {done.returncode}, {done.stderr}")
    lone = window.folder / "alabaster"
    lone.write_bytes(window.program.read_bytes())
    lone.chmod(0o755)
    window.environment["LD_LIBRARY_PATH"] = str(window.program.parents[1] / "lib")
    done = window.run("view", scene, program=lone)
    check(done.returncode == 2 and "libglfw3-dev" in done.stderr, f"without the window: {done.returncode}, {done.stderr}")
