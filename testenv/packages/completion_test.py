#!/usr/bin/env python3
"""Compares the man page and the completions with the helps of the program: each command and flag is in all of them.

  completion_test.py PROGRAM      tries bash and, where they are installed, zsh, fish and man as well
"""
import re
import shlex
import shutil
import subprocess
import sys
import unittest

PROGRAM = sys.argv.pop(1)


def output(*arguments):
    return subprocess.run([PROGRAM, *arguments], check=True, capture_output=True, text=True).stdout


def commands():
    return re.findall(r"^  (\w+) {2,}", output("--help").split("Subcommands:")[1], re.M)


def flags(*command):
    return sorted(set(re.findall(r"^  (?:-\w,)?(--[\w-]+)", output(*command, "--help"), re.M)))


def completed(*words):
    """The words that bash offers for the last of `words`."""
    script = f"{output('completion', 'bash')}\nCOMP_WORDS=({shlex.join(words)})\nCOMP_CWORD={len(words) - 1}\n_alabaster\n" \
             "printf '%s\\n' \"${COMPREPLY[@]}\""
    return subprocess.run(["bash", "-c", script], check=True, capture_output=True, text=True, cwd="/usr/include").stdout.split()


class Completion(unittest.TestCase):
    def test_bash_offers_every_command_and_flag(self):
        self.assertEqual(sorted(completed("alabaster", "")), sorted([*commands(), "--help", "--version"]))
        self.assertGreater(len(flags("render")), 30)
        for command in commands():
            if command != "view":  # has the flags of the window's program
                self.assertLessEqual(set(flags(command)), set(completed("alabaster", command, "--")), command)
        self.assertIn("--json", flags("farm", "status"))
        self.assertIn("--json", completed("alabaster", "farm", "status", "--"))

    def test_bash_offers_files_where_a_flag_takes_one(self):
        self.assertIn("stdio.h", completed("alabaster", "render", "stdi"))
        self.assertIn("stdio.h", completed("alabaster", "render", "scene.json", "--stats", "stdi"))
        self.assertEqual(completed("alabaster", "render", "scene.json", "--spp", "stdi"), [])
        self.assertEqual(completed("alabaster", "render", "--denoi"), ["--denoise"])

    def test_an_unknown_shell_is_refused(self):
        ran = subprocess.run([PROGRAM, "completion", "tcsh"], capture_output=True, text=True)
        self.assertEqual(ran.returncode, 2)
        self.assertIn("bash, zsh or fish", ran.stderr)

    def test_scripts_of_zsh_and_fish_have_every_flag_and_are_valid(self):
        for shell, form in (("zsh", "*{}["), ("fish", "-l {} ")):
            script = output("completion", shell)
            for flag in flags("render"):
                self.assertIn(form.format(flag if shell == "zsh" else flag[2:]), script)
            if shutil.which(shell):
                subprocess.run([shell, "-n", "/dev/stdin"], input=script, text=True, check=True)

    def test_man_page_has_every_flag_and_no_warning(self):
        page = output("man")
        plain = page.replace("\\-", "-")
        for command in commands():
            self.assertIn(f"\n.SH {command.upper()}\n", page)
            for flag in flags(command) if command != "view" else []:
                self.assertIn(f"\\fB{flag}\\fR", plain)
        self.assertIn("\n.SH FARM STATUS\n", page)
        if shutil.which("man"):
            ran = subprocess.run(["man", "--warnings", "-l", "-"], input=page, capture_output=True, text=True)
            self.assertEqual((ran.returncode, ran.stderr), (0, ""))


if __name__ == "__main__":
    unittest.main()
