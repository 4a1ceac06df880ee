#!/usr/bin/env python3
"""Builds the manual as one HTML site, with MkDocs (`pip install mkdocs`).

  build_site.py [--out FOLDER]     default: build/site of the repository; index.html is the README
  build_site.py --check            builds nothing and needs no MkDocs: every link of a page leads to a file, and every section that a page names is there

The pages are those of delegate/manual/mkdocs.yml and all that they link to, at their places in the repository. A name of a page in
backticks, such as `testenv/scenes/README.md`, becomes a link.
"""
import argparse
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

TOP = pathlib.Path(__file__).resolve().parents[2]
CONFIGURATION = TOP / "delegate/manual/mkdocs.yml"
STYLE = TOP / "delegate/manual/site.css"
LINK = re.compile(r"(!?\[(?:[^\]\[]|\[[^\]]*\])*\])\(([^)\s]+)\)")
NAMED = re.compile(r"(?<!\[)`((?:core|delegate|schemas|testenv)/[\w./-]+\.md)`(?!\])")
SECTION = re.compile(r"\]\(([^)\s]+\.md)\),\s\"([^\"]+)\"")
CODE = re.compile(r"^```.*?^```$", re.M | re.S)


def without_code(text):
    return CODE.sub(lambda match: re.sub(r"[^\n]", "", match[0]), text)


def name_of(heading):
    return re.sub(r"\W+", "-", heading.strip("# ")).strip("-")


def for_site(text, page):
    """As MkDocs reads it: names of pages become links to them, and lists and tables stand apart; blocks of code stay as they are."""
    def link(match):
        file = TOP / match[1]
        return f"[{match[0]}]({os.path.relpath(file, page.parent)})" if file.exists() else match[0]

    def prose(part):
        # Python's Markdown begins a list or a table below a paragraph only after an empty line.
        part = re.sub(r"^(?![-|#*] |\d+\. |\s)(.+)\n(?=(?:-|1\.) )", r"\1\n\n", part, flags=re.M)
        part = re.sub(r"^([^|\n].*)\n(?=\|.*\n\|[-:| ]+\n)", r"\1\n\n", part, flags=re.M)
        # It shows the backslash of a bar in code in a table, and needs none there.
        part = re.sub(r"(?<=`)[^`\n]*\\\|[^`\n]*(?=`)", lambda match: match[0].replace("\\|", "|"), part)
        # MkDocs' script for pages ends at an id that begins with a digit, before it styles the tables.
        part = re.sub(r"^#+ (?=\d).*", lambda match: f"{match[0]} {{: #section-{name_of(match[0])} }}", part, flags=re.M)
        # site.css keeps a short flag on one line.
        part = re.sub(r"(?<![`\w\[])`--?[\w=-]{1,24}`(?![`{\w])", lambda match: match[0] + "{: .flag }", part)
        return NAMED.sub(link, part)

    parts = re.split(r"(^```.*?^```$)", text, flags=re.M | re.S)
    return "".join(part if part.startswith("```") else prose(part) for part in parts)


def links_of(page, text):
    """(target, file) of each link into the repository."""
    for _, target in LINK.findall(without_code(text)):
        if not re.match(r"[a-z]+:", target):
            name = target.partition("#")[0]
            yield target, (page.parent / name).resolve() if name else page


def first_pages():
    return [TOP / name for name in re.findall(r": (\S+\.md)$", CONFIGURATION.read_text(), re.M)]


def missing_sections(page, text):
    """A link may be followed by the title of a section in quotes: [usd.md](usd.md), "Lights"."""
    for target, title in SECTION.findall(text):
        file = (page.parent / target).resolve()
        if file.exists() and not re.search(rf"^(?:#+ |\*\*){re.escape(' '.join(title.split()))}\b", file.read_text(), re.M):
            yield f'{page.relative_to(TOP)}: {target} has no section "{title}"'


def collect():
    """The text of each page by file, the other files that they show, and faults."""
    waiting, pages, others, found = first_pages(), {}, set(), []
    while waiting:
        page = waiting.pop()
        if page in pages:
            continue
        if not page.exists():
            found.append(f"{CONFIGURATION.relative_to(TOP)}: there is no {page.relative_to(TOP)}")
            continue
        pages[page] = for_site(page.read_text(), page)
        found += missing_sections(page, pages[page])
        for target, file in links_of(page, pages[page]):
            if not file.is_relative_to(TOP) or not file.exists():
                found.append(f"{page.relative_to(TOP)}: {target} leads to no file of the repository")
            elif file.suffix == ".md":
                waiting.append(file)
            elif file.is_file():
                others.add(file)
    return pages, others, found


def write_pages(folder, pages, others):
    for page, text in pages.items():
        # A folder has no page of its own: its name stays, without a link.
        for target, file in links_of(page, text):
            if file.is_dir():
                text = text.replace(f"]({target})", f"]({os.path.relpath(first_page_of(file), page.parent)})")
        place = folder / page.relative_to(TOP)
        place.parent.mkdir(parents=True, exist_ok=True)
        place.write_text(text)
    for file in {*others, STYLE}:
        place = folder / file.relative_to(TOP)
        place.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(file, place)


def first_page_of(folder):
    return sorted(folder.glob("*.md"))[0]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=pathlib.Path, default=TOP / "build/site")
    parser.add_argument("--check", action="store_true")
    options = parser.parse_args()
    pages, others, found = collect()
    if options.check or found:
        print("\n".join(found) or f"{len(pages)} pages, {len(others)} pictures and other files: every link leads to one")
        return 1 if found else 0
    with tempfile.TemporaryDirectory() as folder:
        write_pages(pathlib.Path(folder), pages, others)
        environment = {**os.environ, "ALABASTER_PAGES": folder, "ALABASTER_SITE": str(options.out.resolve())}
        command = [sys.executable, "-m", "mkdocs", "build", "--strict", "--quiet", "--config-file", str(CONFIGURATION)]
        return subprocess.run(command, env=environment).returncode


if __name__ == "__main__":
    sys.exit(main())
