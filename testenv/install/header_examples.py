#!/usr/bin/env python3
"""The statements between backquotes in the C headers compile without a warning, wherever a host may copy them: those without a
designator in C++11 to C++20, those with one in C99 to C17. So does the header itself in all of these."""
import pathlib
import re
import shutil
import subprocess
import sys

TOP = pathlib.Path(__file__).resolve().parents[2]
ROOM = TOP / "delegate/c_api"
WARNINGS = ["-Wall", "-Wextra", "-pedantic", "-Werror", "-fsyntax-only"]
LANGUAGES = {"c": (("gcc", "clang"), ("c99", "c11", "c17")), "c++": (("g++", "clang++"), ("c++11", "c++14", "c++17", "c++20"))}


def fault_of(statements, language, compiler, standard):
    """The messages of the compiler about functions of these statements; "": none."""
    functions = [f"const void* f{i}(void);\nconst void* f{i}(void) {{ static const void* used; {text} used = &frame; return used; }}\n"
                 for i, text in enumerate(statements)]
    source = "#include <alabaster.h>\n" + "".join(functions)
    ran = subprocess.run([compiler, f"-std={standard}", *WARNINGS, f"-I{TOP}", f"-I{ROOM}", "-x", language, "-"], input=source, text=True,
                         capture_output=True)
    return f"{compiler} -std={standard}: {ran.stderr}" if ran.returncode else ""


def main():
    statements = re.findall(r"`([^`]*;)`", (ROOM / "alabaster.h").read_text())
    of = {"c": [s for s in statements if "{." in s], "c++": [s for s in statements if "{." not in s]}
    found = [f"alabaster.h has no example for {language}" for language in of if not of[language]]
    for language, (compilers, standards) in LANGUAGES.items():
        for compiler in filter(shutil.which, compilers):
            found += [fault_of(of[language], language, compiler, standard) for standard in standards]
    found = [fault for fault in found if fault]
    print("\n".join(found))
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
