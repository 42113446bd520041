"""Reads which headers include which, and fails where the public API includes too much:
check_headers.py FOLDER_OF_THE_PROJECT INSTALLED_HEADER...

Each installed header includes installed ones only, none of them belongs to the modules that reports are
made of, and pvol/embed.h stays light.
"""
import pathlib
import sys
import tempfile

from check_modules import INCLUDE

# For pvol/embed.h, itself included: a little above what it takes. Media hold any phase function, each
# of which is a header.
MOST_HEADERS, MOST_LINES = 25, 1700
# Of headers that stand for each other on different processors, a compiler reads one: these do not count.
ALTERNATIVES = {"pvol/math/float4_neon.h", "pvol/math/float4_plain.h"}
KEPT_WITHIN = ["pvol/measure/"]


def read_headers(library):
    """By name, the lines of each public header and the headers of pvol that it includes."""
    files = {str(path.relative_to(library / "include")): path
             for path in (library / "include/pvol").rglob("*.h*")}
    files["pvol/version.h"] = library / "version.h.in"
    headers = {}
    for name, path in files.items():
        lines = path.read_text().splitlines()
        includes = [include[1] for include in map(INCLUDE.match, lines) if include and include[1]]
        headers[name] = (len(lines), includes)
    return headers


def closure(headers, start):
    """A header and all that it leads to."""
    found, ahead = set(), [start]
    while ahead:
        name = ahead.pop()
        if name not in found and name in headers:
            found.add(name)
            ahead += headers[name][1]
    return found


def find_faults(project, installed):
    headers = read_headers(project / "libpvol")
    # From the build's list, in which names are paths of files.
    installed = {path[path.index("include/pvol/") + len("include/"):] for path in installed}
    faults = [f"{name} is installed, and there is no such header"
              for name in sorted(installed) if name not in headers]
    faults += [f"{name} is installed and includes {include}, which is not"
               for name in sorted(installed) if name in headers
               for include in headers[name][1] if include not in installed]
    faults += [f"{name} is installed, and its module should not be"
               for name in sorted(installed) if name.startswith(tuple(KEPT_WITHIN))]
    manual = closure(headers, "pvol/embed.h") - ALTERNATIVES
    lines = sum(headers[name][0] for name in manual)
    if len(manual) > MOST_HEADERS or lines > MOST_LINES:
        faults.append(f"pvol/embed.h takes {len(manual)} headers of {lines} lines, "
                      f"more than {MOST_HEADERS} of {MOST_LINES}")
    return faults, f"{len(installed)} headers are installed; " \
                   f"pvol/embed.h takes {len(manual)} of {lines} lines"


def self_test():
    """Each fault alone in a project must be found."""
    sound = {"pvol/embed.h": ["pvol/math/vec.h"], "pvol/math/vec.h": [], "pvol/version.h": []}
    many = [f"pvol/math/a{i}.h" for i in range(MOST_HEADERS)]
    unlisted = {**sound, "pvol/math/vec.h": ["pvol/math/box.h"], "pvol/math/box.h": []}
    report = {**sound, "pvol/measure/study.h": []}
    heavy = {**sound, "pvol/embed.h": many, **{name: [] for name in many}}
    cases = [("sound", sound, list(sound), 0),
             ("not installed", unlisted, list(sound), 1),
             ("of reports", report, list(report), 1),
             ("no file", sound, [*sound, "pvol/math/box.h"], 1),
             ("heavy", heavy, list(heavy), 1)]
    for what, headers, installed, count in cases:
        with tempfile.TemporaryDirectory() as folder:
            library = pathlib.Path(folder) / "libpvol"
            for name, includes in headers.items():
                file = library / ("version.h.in" if name == "pvol/version.h" else f"include/{name}")
                file.parent.mkdir(parents=True, exist_ok=True)
                file.write_text("".join(f'#include "{other}"\n' for other in includes))
            faults, _ = find_faults(pathlib.Path(folder), [f"{folder}/include/{name}" for name in installed])
            assert len(faults) == count, f"{what}: {faults}"
    print(f"{len(cases) - 1} planted faults found")


def main():
    if sys.argv[1:] == ["--self-test"]:
        return self_test()
    faults, summary = find_faults(pathlib.Path(sys.argv[1]), sys.argv[2:])
    print("\n".join([*faults, summary]))
    sys.exit(1 if faults else 0)


if __name__ == "__main__":
    main()
