"""Checks the project's text against ``prose.toml``: the textbook's terms, plain English.

    python tools/check_prose.py [FILE ...]

Without files, all that git tracks. Prints ``file:line: word: write ... instead``; exit status 1
where anything was found.
"""

import re
import subprocess
import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
SUFFIXES = {".py", ".pyi", ".rs", ".md", ".toml", ".html", ".js", ".css", ".cff"}


def tracked_files():
    listed = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True)
    return [ROOT / line for line in listed.stdout.splitlines()]


def findings(path, terms):
    """Line number, word and replacement of every word that should be another."""
    for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
        if "_deprecated." in line:
            continue  # It holds an old name.
        text = line.replace("_", " ")
        for pattern, instead in terms:
            for match in pattern.finditer(text):
                yield number, match.group(), instead


def main(arguments):
    rules = tomllib.loads((ROOT / "tools/prose.toml").read_text(encoding="utf-8"))
    terms = [
        (
            re.compile(rf"(?<![A-Za-z])(?:{term['pattern']})(?![A-Za-z])", re.IGNORECASE),
            term["instead"],
        )
        for term in rules["term"]
    ]
    exempt = {ROOT / name for name in rules["exempt"]}
    paths = [Path(a).resolve() for a in arguments] or tracked_files()
    count = 0
    for path in paths:
        if path in exempt or path.suffix not in SUFFIXES or not path.is_file():
            continue
        for number, word, instead in findings(path, terms):
            count += 1
            print(f"{path.relative_to(ROOT)}:{number}: {word!r}: write {instead}")
    return 1 if count else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
