"""Writes the comparison as a Markdown table, and as JSON beside it."""
import json
import pathlib
import platform
import subprocess

HEAD = """# Noise per CPU second, against other renderers

Made by `{command}` on {date} at commit {commit}, on {machine}.

efficiency = 1 / (relMSE x CPU seconds), blocks: the same of the means of 8 x 8 pixels. 'of best Cycles' divides by the best
efficiency of Cycles on the scene. relMSE is the mean of {rounds} seed(s) ± its standard error, each peer against its own
reference of {reference} samples. {samples} samples per pixel, {threads} thread(s), box filter, no denoiser, no clamping,
glossy filter {filters[0]:g} (ours) and {filters[1]:g} (Cycles) but for references.
testenv/benchmark/peers/README.md lists where the renderers differ, which the mean colours show.

"""
COLUMNS = ["scene", "lines", "program", "Msamples / CPU s", "relMSE", "relMSE of blocks", "efficiency", "of best Cycles",
           "blocks: efficiency", "blocks: of best Cycles", "mean R G B"]


def machine():
    model = platform.processor() or platform.machine()
    for line in pathlib.Path("/proc/cpuinfo").read_text().splitlines() if pathlib.Path("/proc/cpuinfo").exists() else []:
        if line.startswith("model name"):
            model = line.split(":", 1)[1].strip()
            break
    return model


def commit():
    root = pathlib.Path(__file__).resolve().parents[3]
    done = subprocess.run(["git", "-C", root, "rev-parse", "--short=7", "HEAD"], capture_output=True, text=True)
    return done.stdout.strip() or "unknown"


def command(options):
    words = ["peers.py", *(f"--ours {entry.split('=', 1)[0]}=PROGRAM" for entry in options["ours"])]
    words += [f"--scene {pathlib.Path(scene).name}" for scene in options["scene"] or []]
    words += ["--peers " + ",".join(options["peers"])]
    words += [f"--{key} {options[key]}" for key in ("lines", "samples", "rounds", "reference", "threads")]
    words += [f"--adaptive {options['adaptive']:g}"] if options["adaptive"] else []
    words += ["--glossy-filter {:g} {:g}".format(*options["glossy_filter"])] if any(options["glossy_filter"]) else []
    return " ".join(words)


def best_cycles(rows, row, key):
    rivals = [r[key] for r in rows if r["scene"] == row["scene"] and r["program"].startswith("Cycles")]
    return max(rivals) if rivals else None


def cells(rows, row):
    def ratio(key):
        best = best_cycles(rows, row, key)
        return f"{row[key] / best:.2f}" if best else "-"

    def noise(key):
        error = row[key + "Error"]
        return f"{row[key]:.3g}" + (f" ± {100 * error:.0f} %" if error is not None else "")

    speed = f"{row['samplesPerCpuSecond'] / 1e6:.3f}" if row["ours"] or not row["program"].endswith("adaptive") else "-"
    return [row["scene"], str(row["lines"]), row["program"], speed, noise("relMse"),
            noise("blockRelMse"), f"{row['efficiency']:.3g}", ratio("efficiency"), f"{row['blockEfficiency']:.3g}",
            ratio("blockEfficiency"), " ".join(f"{c:.4f}" for c in row["mean"])]


def write(path, facts):
    options, rows = facts["options"], facts["rows"]
    text = HEAD.format(command=command(options), date=facts["date"], commit=commit(), machine=machine(),
                       rounds=options["rounds"], reference=2 * options["reference"], samples=options["samples"],
                       threads=options["threads"], filters=options["glossy_filter"])
    text += "| " + " | ".join(COLUMNS) + " |\n|" + "--|" * len(COLUMNS) + "\n"
    text += "".join("| " + " | ".join(cells(rows, row)) + " |\n" for row in rows)
    text += "".join(f"\n{reason}\n" for reason in facts["leftOut"])
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)
    kept = {key: value for key, value in options.items() if key not in ("work", "out", "ours", "scene")}
    path.with_suffix(".json").write_text(json.dumps(
        {"command": command(options), "commit": commit(), "machine": machine(), "date": facts["date"], "options": kept,
         "leftOut": facts["leftOut"], "rows": rows}, indent=1) + "\n")
