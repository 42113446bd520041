"""Reads which headers include which, and fails where the library's doors do not shut:
check_headers.py FOLDER_OF_THE_PROJECT

libpvol/public_headers.txt lists the headers that are installed. Each of them includes installed
headers only, each is a door or needed by one, and pvol/embed.h stays light.
"""
import pathlib
import sys
import tempfile

from check_rooms import INCLUDE

# What programs include by name; the other installed headers follow from these.
DOORS = ["pvol/embed.h", "pvol/trackers.h", "pvol/error.h", "pvol/version.h",
         "pvol/density/recipe.h", "pvol/render/render.h", "pvol/render/scene_volume.h"]
# For pvol/embed.h, itself included: a little above what it takes.
MOST_HEADERS, MOST_LINES = 20, 1350


def read_headers(library):
    """By name, the lines of each public header and the headers of pvol that it includes."""
    files = {str(path.relative_to(library / "include")): path
             for path in (library / "include/pvol").rglob("*.h")}
    files["pvol/version.h"] = library / "version.h.in"
    headers = {}
    for name, path in files.items():
        lines = path.read_text().splitlines()
        includes = [include[1] for include in map(INCLUDE.match, lines) if include and include[1]]
        headers[name] = (len(lines), includes)
    return headers


def closure(headers, doors):
    """The doors and all that they lead to."""
    found, ahead = set(), list(doors)
    while ahead:
        name = ahead.pop()
        if name not in found and name in headers:
            found.add(name)
            ahead += headers[name][1]
    return found


def find_faults(project):
    library = project / "libpvol"
    headers = read_headers(library)
    listed = [line for line in (library / "public_headers.txt").read_text().splitlines()
              if line and line[0] != "#"] + ["pvol/version.h"]
    faults = [f"{name} is listed twice" for name in set(listed) if listed.count(name) > 1]
    faults += [f"{name} is listed, and there is no such header"
               for name in listed if name not in headers]
    faults += [f"{name} is a door and not installed" for name in DOORS if name not in listed]
    faults += [f"{name} is installed and includes {include}, which is not"
               for name in listed if name in headers
               for include in headers[name][1] if include not in listed]
    reached = closure(headers, DOORS)
    faults += [f"{name} is installed, and no door leads to it"
               for name in listed if name in headers and name not in reached]
    manual = closure(headers, ["pvol/embed.h"])
    lines = sum(headers[name][0] for name in manual)
    if len(manual) > MOST_HEADERS or lines > MOST_LINES:
        faults.append(f"pvol/embed.h takes {len(manual)} headers of {lines} lines, "
                      f"more than {MOST_HEADERS} of {MOST_LINES}")
    return faults, f"{len(listed)} headers are installed; " \
                   f"pvol/embed.h takes {len(manual)} of {lines} lines"


def self_test():
    """Each fault alone in a project must be found."""
    sound = {name: [] for name in DOORS}
    sound["pvol/embed.h"] = ["pvol/math/vec.h"]
    sound["pvol/math/vec.h"] = []
    many = [f"pvol/math/a{i}.h" for i in range(MOST_HEADERS)]
    unlisted = {**sound, "pvol/math/vec.h": ["pvol/math/box.h"], "pvol/math/box.h": []}
    needless = {**sound, "pvol/math/box.h": []}
    heavy = {**sound, "pvol/embed.h": many, **{name: [] for name in many}}
    del heavy["pvol/math/vec.h"]
    cases = [("sound", sound, list(sound), 0),
             ("not installed", unlisted, list(sound), 1),
             ("no door", needless, list(needless), 1),
             ("no file", sound, [*sound, "pvol/math/box.h"], 1),
             ("twice", sound, [*sound, "pvol/error.h"], 1),
             ("a shut door", sound, [name for name in sound if name != "pvol/trackers.h"], 1),
             ("heavy", heavy, list(heavy), 1)]
    for what, headers, listed, count in cases:
        with tempfile.TemporaryDirectory() as folder:
            library = pathlib.Path(folder) / "libpvol"
            for name, includes in headers.items():
                file = library / ("version.h.in" if name == "pvol/version.h" else f"include/{name}")
                file.parent.mkdir(parents=True, exist_ok=True)
                file.write_text("".join(f'#include "{other}"\n' for other in includes))
            names = [name for name in listed if name != "pvol/version.h"]
            (library / "public_headers.txt").write_text("# Listed.\n" + "\n".join(names) + "\n")
            faults, _ = find_faults(pathlib.Path(folder))
            assert len(faults) == count, f"{what}: {faults}"
    print(f"{len(cases) - 1} planted faults found")


def main():
    if sys.argv[1:] == ["--self-test"]:
        return self_test()
    faults, summary = find_faults(pathlib.Path(sys.argv[1]))
    print("\n".join([*faults, summary]))
    sys.exit(1 if faults else 0)


if __name__ == "__main__":
    main()
