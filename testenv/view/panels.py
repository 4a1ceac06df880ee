"""Frame rates of the window and a screenshot of each panel, into testenv/view/results."""
import os
import pathlib
import shutil
import subprocess

HERE = pathlib.Path(__file__).resolve().parent
SCENES = HERE.parent / "scenes"
PANELS = ["Material", "Light", "Camera", "Render", "Save", "Messages"]
ANONYMOUS = ["--nosoftwareattrib", "--eraseattrib", ".*"]  # no paths of this machine in a picture
BEFORE = {"Render": ['choose Pixels "1/2 of that"', "wait converged 900"], "Save": ['press "Save picture"'],
          "Messages": ["press Save", 'type "description file" sample.json', 'press "Save description"', "press Messages"]}
MEASURED = ["hard_light", "backlit", "mixed_no_subsurface"]


def frame_rates(window):
    """Rows of the table: scene, what is done, frames as the window counts them."""
    for scene in MEASURED:
        first, refining, dragged, edited = window.play(SCENES / scene / f"{scene}.json", [
            "size 1280 760", "wait covered 120", "state", "wait seconds 10", "state",
            *(f"drag left 0.5 0.5 {0.5 + 0.02 * (-1) ** k} 0.5" for k in range(8)), "state",
            "press Material", *(f"slide roughness {0.3 + 0.05 * k}" for k in range(8)), "state"])
        for what, state in (("until it covers the frame", first), ("refining", refining), ("drags of the camera", dragged),
                            ("drags of a slider", edited)):
            yield scene, what, state["frames"], state["size"]


def table(rows, load):
    yield "# Frames of the window while it renders"
    yield ""
    yield (f"By `run_window.py --results` on {os.cpu_count()} cores, all of which the renderer takes, as did other programs (load average "
           f"{load:.0f}); OpenGL by software, which is slower than that of a graphics card. The window aims at 60 frames per second. Work: "
           "milliseconds of the window's thread for a frame, without the wait for the screen. Interval: from a frame to the next.")
    yield ""
    yield "| scene | while | pixels | frames | per second | work, median | work, 95 % | interval, 95 % | longest |"
    yield "| --- | --- | --- | --- | --- | --- | --- | --- | --- |"
    for scene, what, frames, (width, height) in rows:
        numbers = [f"{frames[name]:.1f}" for name in ("workMedianMs", "workP95Ms", "intervalP95Ms", "intervalWorstMs")]
        yield (f"| {scene} | {what} | {width} x {height} | {frames['count']} | {frames['perSecond']:.0f} | " + " | ".join(numbers) + " |")


def panels(window):
    """Screenshots of all panels, and one of the denoised picture beside the plain one."""
    for name in ("sample.json", "sample.glb"):
        shutil.copy(SCENES / "sample" / name, window.folder)  # so that fields show no folders of this machine
    lines = ["size 1280 760", "wait covered 200", "click 0.5 0.45"]
    for name in PANELS:
        lines += [f"press {name}", *BEFORE.get(name, []), "wait seconds 1", f"screenshot {name}.ppm"]
    window.play("sample.json", lines)
    window.play("sample.json", ["size 1440 860", "press Render", "type samples 16", "press Material", 'press "Side by side"',
                                "wait converged 1500", "click 0.5 0.45", "wait seconds 2", "screenshot side.ppm"])


def looks(window):
    """A look that is kept beside another one, of other petals under one more light."""
    window.play("sample.json", [
        "size 1000 640", "press Render", "type samples 16", "wait converged 900", "key w",
        "press Material", 'press "constant##baseColor"', "type baseColor.r 0.95", "type baseColor.g 0.6", "type baseColor.b 0.15",
        "type roughness 0.15", "press Light", "choose add rectLight", "type intensity 30", "type color.g 0.8", "type color.b 0.55",
        "press Highlight", "wait covered 200", "click 0.9 0.6", "wait converged 900", "wait seconds 1", "screenshot looks.ppm"])


def write_pictures(window, out):
    panels(window)
    looks(window)
    files = [str(window.folder / f"{name}.ppm") for name in PANELS]
    jpeg = ["--compression", "jpeg:88", *ANONYMOUS, "-o"]
    subprocess.run(["oiiotool", *files, "--mosaic:pad=8", "2x3", "--resize", "1600x0", *jpeg, str(out / "panels.jpg")], check=True)
    subprocess.run(["oiiotool", str(window.folder / "side.ppm"), *jpeg, str(out / "window.jpg")], check=True)
    subprocess.run(["oiiotool", str(window.folder / "looks.ppm"), *jpeg, str(out / "looks.jpg")], check=True)


def write_results(window):
    out = HERE / "results"
    out.mkdir(exist_ok=True)
    write_pictures(window, out)
    (out / "frame_rates.md").write_text("\n".join(table(list(frame_rates(window)), os.getloadavg()[0])) + "\n")
    print(f"wrote frame_rates.md, panels.jpg, window.jpg and looks.jpg into {out}")
