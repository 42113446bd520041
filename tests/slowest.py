#!/usr/bin/env python3
"""Prints the twenty sources and tests of a build folder that took longest: slowest.py BUILD

Sources by Ninja's log, in seconds from begin to end, so that more jobs than cores make them longer; tests by
what GoogleTest wrote of each case.
"""
import json
import pathlib
import sys

SHOWN = 20


def sources(build):
    """(seconds, name) of each object that the last build of it made."""
    last = {}
    for line in (build / ".ninja_log").read_text().splitlines()[1:]:
        begin, end, _, output, _ = line.split("\t")
        if output.endswith(".o") and not output.startswith("/"):
            last[output] = (int(end) - int(begin)) / 1000
    return [(seconds, name.replace("CMakeFiles/", "").removesuffix(".o")) for name, seconds in last.items()]


def cases(build):
    """(seconds, name) of each case of the last run."""
    found = []
    for file in sorted((build / "times").glob("*.json")):
        try:
            report = json.loads(file.read_text())
        except ValueError:  # a test that did not end
            continue
        for suite in report["testsuites"]:
            for case in suite["testsuite"]:
                name = f"{file.stem}: {suite['name']}.{case['name']}"
                found.append((float(case["time"].removesuffix("s")), name))
    return found


def show(title, rows):
    print(f"\n{title}: {sum(seconds for seconds, _ in rows):.0f} s in all")
    for seconds, name in sorted(rows, reverse=True)[:SHOWN]:
        print(f"{seconds:8.1f} s  {name}")


def main():
    if len(sys.argv) != 2 or not (pathlib.Path(sys.argv[1]) / ".ninja_log").exists():
        sys.exit("slowest.py: expected a build folder of Ninja, such as build/ci")
    build = pathlib.Path(sys.argv[1])
    show("Sources", sources(build))
    show("Tests", cases(build))


if __name__ == "__main__":
    main()
