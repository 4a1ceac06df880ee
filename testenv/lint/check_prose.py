#!/usr/bin/env python3
"""Fails on comments and sentences that a reader has to read twice.

- A comment does not open with a word of FIRST: its subject comes first. No later sentence of a comment, and no sentence of
  a Markdown page, opens with a word of ANY, which make a clause or a fragment of the subject. Questions may.
- No comment, no string that users see, and no page holds a phrase of BANNED.
- No line of a comment ends early where a formatter broke the line before it.

Rooms in NOT_YET are not checked yet.
"""
import ast
import io
import pathlib
import re
import sys
import tokenize

FIRST = {"Of", "Its", "Whether", "That", "What", "Ditto"}
ANY = {"Of", "Whether", "What", "Ditto"}
BANNED = [
    r"\bforet(old|ell)", r"\brenders more\b", r"\bnothing to set\b", r"\bwhat there (is|was)\b", r"\btold from\b", r"\bnor cheaper\b",
    r"' is no\b", r"\bgoes on (with|from)\b", r"\bheld against\b", r"\b(says?|tells?) nothing\b", r"\bdear(er|est)\b",
    r"\bfor ever\b", r"\bhangs? together\b", r"\banew\b", r"\bwhoever\b",
    r"[;:] what (?!if\b)",  # a clause as a subject
]
NOT_YET = []
PROMISE = " promise: "  # names of check_promises.py, no sentence
WIDTH = 120

CPP_TOKEN = re.compile(r'R"(\w*)\((?:.|\n)*?\)\1"|"(?:\\.|[^"\\\n])*"|' r"'(?:\\.|[^'\\\n])+'|//[^\n]*|/\*(?:.|\n)*?\*/")
SENTENCE = re.compile(r"(?<=[.?!])\s+(?=[A-Z`(])")


class Comment:
    """Lines that follow each other with one marker at one column."""

    def __init__(self, number, column, marker, text, alone):
        self.number, self.column, self.marker, self.alone, self.lines = number, column, marker, alone, [text]

    def takes(self, other):
        return (self.alone and other.alone and other.number == self.number + len(self.lines)
                and (other.column, other.marker) == (self.column, self.marker))


def cpp_texts(text):
    """Comments of a C++ file, and (line, string) of its literals, those that stand side by side joined."""
    comments, strings, end = [], [], -1
    for match in CPP_TOKEN.finditer(text):
        token, number = match.group(), text.count("\n", 0, match.start()) + 1
        start = text.rfind("\n", 0, match.start()) + 1
        if token.startswith("//"):
            marker = re.match(r"///?<?", token).group()
            comments.append(Comment(number, match.start() - start, marker, token[len(marker):].rstrip(),
                                    not text[start:match.start()].strip()))
        elif token.startswith(('"', 'R"')) and not text[start:match.start()].lstrip().startswith("#"):
            if end >= 0 and not text[end:match.start()].strip():
                strings[-1] = (strings[-1][0], strings[-1][1] + token[1:-1])
            else:
                strings.append((number, token[1:-1]))
            end = match.end()
    return comments, strings


def python_texts(text):
    comments, strings = [], []
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type == tokenize.COMMENT and not token.string.startswith("#!"):
            alone = not token.line[:token.start[1]].strip()
            comments.append(Comment(token.start[0], token.start[1], "#", token.string[1:].rstrip(), alone))
    tree = ast.parse(text)
    documented = set()
    for node in ast.walk(tree):
        if isinstance(node, (ast.Module, ast.ClassDef, ast.FunctionDef)) and ast.get_docstring(node):
            literal = node.body[0].value
            documented.add(id(literal))
            comment = Comment(literal.lineno, literal.col_offset, '"""', "", True)
            comment.lines = [" " + line if line else "" for line in ast.get_docstring(node).splitlines()]
            comments.append(comment)
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in documented:
            strings.append((node.lineno, node.value))
    return comments, strings


def shell_texts(text):
    comments = [Comment(n, line.index("#"), "#", line.lstrip()[1:], True)
                for n, line in enumerate(text.splitlines(), 1) if line.lstrip().startswith("#") and not line.startswith("#!")]
    return comments, [(n, line) for n, line in enumerate(text.splitlines(), 1) if not line.lstrip().startswith("#")]


def blocks_of(comments):
    blocks = []
    for comment in comments:
        if comment.lines[0].startswith(PROMISE):
            continue
        if blocks and blocks[-1].takes(comment):
            blocks[-1].lines += comment.lines
        else:
            blocks.append(comment)
    return blocks


def opener_faults(text, first):
    for index, sentence in enumerate(SENTENCE.split(text.strip())):
        word = re.match(r"[A-Za-z]*", sentence).group()
        if word in (first if index == 0 else ANY) and not sentence.rstrip().endswith("?"):
            yield f"opens with '{word}': {sentence[:60]}"


def banned_faults(text):
    for phrase in BANNED:
        match = re.search(phrase, text, re.I)
        if match:
            yield f"holds '{match.group()}'"


def broken_lines(block):
    """Numbers of lines that end early, though the next word would fit, below a line that was broken for being full."""
    room = WIDTH - block.column - len(block.marker)
    for index in range(1, len(block.lines) - 1):
        before, line, after = block.lines[index - 1:index + 2]
        if not line.startswith(" ") or re.match(r"\s*(\s|[-*`|\d]|$)", after[1:]) or re.match(r" (\s|[-*|]|$)", line):
            continue
        full = len(before) + 1 + len(line.split()[0]) > room
        if full and len(line) + 1 + len(after.split()[0]) <= room and len(line) < room / 2:
            yield block.number + index


def comment_faults(path, text, read):
    comments, strings = read(text)
    for block in blocks_of(comments):
        joined = " ".join(line.strip() for line in block.lines)
        for fault in [*opener_faults(joined, FIRST), *banned_faults(joined)]:
            yield f"{path}:{block.number}: {fault}"
        if block.marker != '"""':
            for number in broken_lines(block):
                yield f"{path}:{number}: line breaks early"
    for number, string in strings:
        for fault in banned_faults(string):
            yield f"{path}:{number}: {fault}"


def markdown_faults(path, text):
    text = re.sub(r"```.*?```", lambda match: "\n" * match.group().count("\n"), text, flags=re.S)
    number = 1
    for paragraph in text.split("\n\n"):
        headings = re.findall(r"^#.*$", paragraph, re.M)
        rest = re.sub(r"^#.*\n?", "", paragraph, flags=re.M)
        pieces = re.split(r"\||\n", rest) if rest.lstrip().startswith("|") else re.split(r"\n(?=[-*] |\d\. )", rest)
        for piece in headings + pieces:
            joined = " ".join(piece.split()).lstrip("#-* ")
            for fault in [*opener_faults(joined, ANY), *banned_faults(joined)]:
                yield f"{path}:{number}: {fault}"
        number += paragraph.count("\n") + 2


def text_faults(path, text):
    for number, line in enumerate(text.splitlines(), 1):
        for fault in banned_faults(line):
            yield f"{path}:{number}: {fault}"


READERS = {".h": cpp_texts, ".cpp": cpp_texts, ".py": python_texts, ".sh": shell_texts}


def faults(path, text):
    suffix = pathlib.PurePath(path).suffix
    if suffix in READERS:
        return comment_faults(path, text, READERS[suffix])
    return (markdown_faults if suffix == ".md" else text_faults)(path, text)


def main():
    root = pathlib.Path(__file__).resolve().parents[2]
    found, count = [], 0
    files = [root / "README.md"] + sorted(p for folder in ("core", "delegate", "schemas", "testenv")
                                          for p in (root / folder).rglob("*") if p.suffix in (*READERS, ".md", ".json"))
    for file in files:
        path = file.relative_to(root).as_posix()
        if path.startswith(("testenv/lint/check_prose", *NOT_YET)):
            continue
        found += faults(path, file.read_text())
        count += 1
    print("\n".join(found) if found else f"{count} files read well")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
