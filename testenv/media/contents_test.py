#!/usr/bin/env python3
"""Compares bodies that scatter behind a clear wall, with something in them (scenes.py), with pictures of Mitsuba 3 in references.json.

  contents_test.py [--only REGEX]            needs our Python module in PYTHONPATH
  contents_test.py --write [--only REGEX]    renders the references again; needs mitsuba (pip install mitsuba), and not the module

Blocks of 6 x 6 pixels and the whole picture are compared, each channel that differs from the one before: |z| is at most what chance exceeds
in one of a thousand runs (Sidak). Both have a standard error of at most .3 % in each block, of the picture's mean if that is more.
"""
import argparse
import hashlib
import json
import pathlib
import re
import sys
import time
from types import SimpleNamespace

import numpy as np

from scenes import BLOCK, NOISE, PIXELS, SCENES

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "matrix"))
REFERENCES = HERE / "references.json"
ERROR = 0.003
SEEDS = (12, 24, 48, 96, 192)


def regions(pixels):
    """Means of blocks, then of the picture, each with its channels."""
    n = PIXELS // BLOCK
    each = pixels.reshape(n, BLOCK, n, BLOCK, 3).mean(axis=(1, 3)).reshape(-1, 3)
    return np.vstack([each, pixels.mean(axis=(0, 1))])


def statistics(name, pictures, error):
    """Mean and standard error of each region, of as many pictures as they need."""
    values = []
    for count in SEEDS:
        while len(values) < count:
            values.append(regions(next(pictures)))
        mean, se = np.mean(values, axis=0), np.std(values, axis=0, ddof=1) / np.sqrt(count)
        noise = (se / np.maximum(mean, mean[-1])).max()
        if noise <= error:
            return SimpleNamespace(mean=mean, error=se, values=values)
    sys.exit(f"{name}: {noise:.4f} of noise after {count} pictures, and not {error}")


def digest(scene):
    """Of all that its picture depends on."""
    text = json.dumps([scene._asdict(), PIXELS], default=lambda a: np.round(a, 9).tolist() if isinstance(a, np.ndarray) else vars(a))
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def write(chosen):
    import mitsuba
    from in_mitsuba import pictures
    kept = json.loads(REFERENCES.read_text()) if REFERENCES.exists() else {"scenes": {}}
    kept.update(by=f"Mitsuba {mitsuba.__version__}, scalar_rgb, volpath", command="testenv/media/contents_test.py --write")
    for name in chosen:
        begin = time.process_time()
        found = statistics(name, pictures(SCENES[name], 128), NOISE.get(name, ERROR))
        kept["scenes"][name] = {"scene": digest(SCENES[name]), "pictures": len(found.values),
                                "mean": found.mean.round(5).tolist(), "error": found.error.round(6).tolist()}
        print(f"{name}: {len(found.values)} pictures, {found.mean[-1].round(4)} [{time.process_time() - begin:.0f} s]", flush=True)
    kept["scenes"] = {name: kept["scenes"][name] for name in SCENES if name in kept["scenes"]}
    lines = ",\n".join(f' {json.dumps(name)}: {json.dumps(entry)}' for name, entry in kept["scenes"].items())
    head = ", ".join(f'"{key}": {json.dumps(kept[key])}' for key in ("by", "command"))
    REFERENCES.write_text(f'{{{head}, "scenes": {{\n{lines}}}}}\n')


def compare(chosen):
    from in_ours import scene_of
    from measure import SIGNIFICANCE, NormalDist, picture, renderer_of, z_of

    def drawn(scene):
        made, camera = scene_of(scene)
        renderer, seed = renderer_of(made, samples=256), 0
        while True:
            renderer.set(seed=seed)
            yield picture(renderer, camera, PIXELS)
            seed += 1
    references = json.loads(REFERENCES.read_text())["scenes"]
    comparisons = sum(np.array(r["mean"]).size for r in references.values())
    limit = NormalDist().inv_cdf(1 - (1 - (1 - SIGNIFICANCE) ** (1 / comparisons)) / 2)
    wrong = 0
    for name in chosen:
        begin, given = time.process_time(), references.get(name, {"scene": "missing"})
        if given["scene"] != digest(SCENES[name]):
            sys.exit(f"{name}: references.json has another scene of this name; render it again: --write --only '{name}'")
        reference = SimpleNamespace(mean=np.array(given["mean"]), error=np.array(given["error"]), values=range(given["pictures"]))
        ours = statistics(name, drawn(SCENES[name]), NOISE.get(name, ERROR))
        z = np.abs(z_of(ours, reference))
        holds, worst = z.max() <= limit, np.unravel_index(z.argmax(), z.shape)
        wrong += not holds
        print(f"{'holds' if holds else 'WRONG'}: {name}: picture {ours.mean[-1].round(4)}, reference {reference.mean[-1].round(4)}; largest z "
              f"{z.max():.1f}, {ours.mean[worst]:.4f} for {reference.mean[worst]:.4f} in region {worst[0]} [{time.process_time() - begin:.0f} s]",
              flush=True)
    print(f"{len(chosen) - wrong} of {len(chosen)} scenes hold; z up to {limit:.2f} of {comparisons} comparisons")
    return 1 if wrong else 0


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--only", default="")
    options = parser.parse_args()
    chosen = [name for name in SCENES if re.search(options.only, name)]
    return write(chosen) if options.write else compare(chosen)


if __name__ == "__main__":
    sys.exit(main())
