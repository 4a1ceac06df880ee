"""A picture of ours and Cycles' pictures of each scene, side by side."""
import pathlib
import shutil
import subprocess

COLUMNS = 3
ANONYMOUS = ["--nosoftwareattrib", "--eraseattrib", ".*"]  # no paths of this machine in a picture


def sheet(names, engine, folder, out):
    """Reads FOLDER/NAME.ENGINE.exr and FOLDER/NAME.cycles.exr of each scene."""
    if not shutil.which("oiiotool"):
        print("no picture: oiiotool is missing (apt-get install openimageio-tools)")
        return
    pairs = []
    for name in names:
        pair = pathlib.Path(folder) / f"{name}.pair.exr"
        files = [pathlib.Path(folder) / f"{name}.{one}.exr" for one in (engine, "cycles")]
        subprocess.run(["oiiotool", *files, "--mosaic:pad=2", "2x1", "--ch", "R,G,B", "-o", pair], check=True)
        pairs.append(pair)
    subprocess.run(["oiiotool", *pairs, "--mosaic:pad=8", f"{COLUMNS}x{-(-len(pairs) // COLUMNS)}", "--colorconvert", "linear", "sRGB",
                    "--compression", "jpeg:85", *ANONYMOUS, "-o", out], check=True)
