#!/usr/bin/env python3
"""Tests presets_from_tradeoff.py on reports with known answers: noise^2 = 9 / samples, a tenth of a second per sample."""
import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

SCRIPT = pathlib.Path(__file__).with_name("presets_from_tradeoff.py")


class FromTradeoff(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.presets = pathlib.Path(self.folder.name) / "presets.json"
        self.presets.write_text(json.dumps({"presets": [
            {"name": "draft", "settings": {"subsurface": "walk", "adaptive": True, "samples": 512, "targetError": 0.3}},
            {"name": "production", "settings": {"subsurface": "walk", "samples": 1000, "targetError": 0.03}}]}))

    def report(self, name, draft_bias2=0.16, low=0.1, rungs=(1, 4, 16, 64), adaptive="true"):
        rows = []
        for preset, bias2, bias_low in (("draft", draft_bias2, low), ("production", 1e-6, -1e-5)):
            rows += [{"configuration": "quality=" + preset, "samples": n, "cpuSeconds": 0.1 * n, "noise2": 9 / n,
                      "bias2": bias2, "bias2Low": bias_low} for n in rungs]
        file = pathlib.Path(self.folder.name) / (name + ".json")
        file.write_text(json.dumps({
            "scene": f"scenes/{name}/scene.json", "resolution": [64, 48], "rows": rows, "configurations": [
                {"name": "quality=draft", "settings": "coarser 0; adaptive " + adaptive + "; subsurface \"auto\""},
                {"name": "quality=production", "settings": "coarser 0; subsurface \"walk\""}]}))
        return str(file)

    def run_script(self, *reports):
        return subprocess.run([sys.executable, SCRIPT, "--command", "how", "--presets", self.presets, *reports],
                              capture_output=True, text=True)

    def test_numbers(self):
        done = self.run_script(self.report("wax"), self.report("skin"))
        self.assertEqual(done.returncode, 0, done.stderr)
        draft, production = json.loads(self.presets.read_text())["presets"]
        self.assertEqual(draft["measured"]["settings"], draft["settings"])
        self.assertEqual(draft["measured"]["command"], "how")
        self.assertEqual(list(draft["measured"]["scenes"]), ["wax", "skin"])
        # Noise 0.3 at 100 samples, between and beyond the rungs; with the bias of 0.4 the error is 0.5.
        wax = draft["measured"]["scenes"]["wax"]
        self.assertEqual(wax["samples"], 100)
        for key, value in {"noise": 0.3, "bias": 0.4, "error": 0.5, "cpuSeconds": 10, "timeOfProduction": 0.1}.items():
            self.assertAlmostEqual(wax[key], value, delta=0.005 * value, msg=key)
        # Noise 0.03 would take 10000 samples, so 'samples' ends it. The bias cannot be distinguished from zero.
        wax = production["measured"]["scenes"]["wax"]
        self.assertEqual((wax["samples"], wax["highestRung"], wax["bias"], wax["cpuSeconds"]), (1000, 64, 0, 100))
        self.assertAlmostEqual(wax["error"], 0.0949, delta=1e-4)

    def test_refusals(self):
        before = self.presets.read_text()
        for reports, words in (([self.report("few", rungs=(1,))], "--budget"),
                               ([self.report("other", adaptive="false")], "adaptive"),
                               ([self.report("twice")] * 2, "twice"),
                               ([str(self.presets)], "not a report"), (["absent.json"], "absent.json")):
            done = self.run_script(*reports)
            self.assertEqual(done.returncode, 1)
            self.assertIn(words, done.stderr)
            self.assertNotIn("Traceback", done.stderr)
            self.assertEqual(self.presets.read_text(), before)


if __name__ == "__main__":
    unittest.main()
