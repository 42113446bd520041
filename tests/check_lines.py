"""Whether documents and sources are short enough to be read: check_lines.py ROOT, or --self-test

Lines of documents have at most 110 columns, but for tables, code, and what a program writes; sources of
the library, the formats and the tools have at most 450 lines.
"""
import pathlib
import sys

FOLDERS = ("formats", "libpvol", "samples", "tests", "tools")
WRITTEN_BY_PROGRAMS = {"tests/bench/EXTREMES.md"}
MOST_COLUMNS, MOST_LINES = 110, 450


def faults_of(name, text):
    lines, faults, code = text.splitlines(), [], False
    if name.endswith(".md") and name not in WRITTEN_BY_PROGRAMS:
        for number, line in enumerate(lines, 1):
            code ^= line.startswith("```")
            if len(line) > MOST_COLUMNS and not code and not line.startswith(("|", "    ")):
                faults.append(f"{name}:{number}: {len(line)} columns; expected at most {MOST_COLUMNS}")
    elif name.startswith(("libpvol/", "formats/", "tools/")) and name.endswith((".cpp", ".h")):
        if len(lines) > MOST_LINES:
            faults.append(f"{name}: {len(lines)} lines; expected at most {MOST_LINES}")
    return faults


def self_test():
    """Each planted fault must be found, and nothing else."""
    long, lines = "x" * 111, "\n" * 451
    planted = [("a.md", f"```\n{long}\n```\n{long}"), ("libpvol/a.h", lines), ("tools/cli/a.cpp", lines)]
    right = [("a.md", f"| {long}\n```\n{long}\n```\n    {long}\n{long[1:]}"), ("tools/a.py", lines),
             ("tests/a_test.cpp", lines), ("libpvol/a.cpp", lines[1:])]
    for name, text in planted:
        assert len(faults_of(name, text)) == 1, name
    for name, text in right:
        assert not faults_of(name, text), name
    print(f"{len(planted)} planted faults found")


def main():
    if sys.argv[1:] == ["--self-test"]:
        return self_test()
    root = pathlib.Path(sys.argv[1])
    files = [*root.glob("*.md"), *(p for folder in FOLDERS for p in (root / folder).rglob("*.*"))]
    files = [p for p in files if p.suffix in (".md", ".cpp", ".h")]
    faults = [f for p in sorted(files) for f in faults_of(p.relative_to(root).as_posix(), p.read_text())]
    print("\n".join(faults) or f"{len(files)} files")
    sys.exit(1 if faults or not files else 0)


if __name__ == "__main__":
    main()
