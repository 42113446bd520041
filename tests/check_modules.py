"""Reads every include line and fails on an include that goes the wrong way: check_modules.py PROJECT

The modules and what each may see are described in libpvol/SOURCES.md. A module sees itself and the modules
listed before it, whether as public headers ("pvol/MODULE/x.h") or as its sources' own ("MODULE/x.h"). The
renderer is eight modules in src/render, whose public headers share a folder: pvol/render.
"""
import pathlib
import re
import sys
import tempfile

RENDER = ["film", "scene", "denoise", "light", "path", "guide", "engine", "plan"]
LIBRARY = ["math", "form", "density", "bounds", "field", "shell", "track", "volume",
           *(f"render/{m}" for m in RENDER), "measure", "capi"]
# Public headers of the renderer that do not describe a scene. What a plan holds is known to the paths that
# follow it; who makes it comes last.
RENDER_HEADERS = {
    "film": "adaptive_samples aov counts deep film film_channels film_sums",
    "denoise": "denoise",
    "light": "daylight lighting lights near_lights sky_light sun_position",
    "path": "guide_choice plan shell_choice",
    "engine": "render",
    "plan": "cost_map"}
ROOT_HEADERS = {"pvol/error.h": "math", "pvol/version.h": "math", "pvol/embed.h": "volume",
         "pvol/trackers.h": "volume", "pvol/pvol.h": "capi", "pvol/pvol.hpp": "capi",
         "pvol/given_density.h": "capi"}
TOOLS = ["cli", "report", "stats", "view", "python"]
FORMATS = ["file", "image", "toml", "vdb", "pvol", "pbrt", "usda"]
# What the library is built from: the standard library, compilers' own headers of vector instructions,
# oneTBB, Embree and nothing else.
AT_HOME_IN_LIBRARY = re.compile(
    r"<(tbb/\w+\.h|hwy/\w+\.h|embree3/rtcore\.h|sys/(auxv|mman|resource)\.h|unistd\.h|std(def|int)\.h"
    r"|[es]mmintrin\.h|arm_neon\.h|[a-z_0-9]+)>$")

INCLUDE = re.compile(r'^\s*#\s*include\s+(?:"([^"]+)"|(<[^>]+>))')


def library_target(name):
    """The library's module that an include names, or None."""
    if name in ROOT_HEADERS:
        return ROOT_HEADERS[name]
    public = name.startswith("pvol/")
    first, _, rest = name.removeprefix("pvol/").partition("/")
    if first == "render":
        first += "/" + (module_of_render_header(rest) if public else rest.partition("/")[0])
    return first if rest and first in LIBRARY else None


def module_of_render_header(name):
    stem = name.removesuffix(".h")
    return next((m for m, stems in RENDER_HEADERS.items() if stem in stems.split()), "scene")


def module_of_library_file(path):
    """The module of libpvol/src/MODULE/... or libpvol/include/pvol/MODULE/..."""
    parts = path.parts
    return library_target("/".join(parts[parts.index("src") + 1:] if "src" in parts else
                                   parts[parts.index("include") + 1:]))


def climbs(order, own, other):
    return order.index(other) > order.index(own)


def check_library(path, name, foreign):
    if foreign:
        return not AT_HOME_IN_LIBRARY.match(foreign) and "libpvol needs oneTBB, Embree and Highway only"
    if name.startswith("pvol/formats/"):
        return "libpvol does not see formats"
    own, other = module_of_library_file(path), library_target(name)
    if own is None:
        return "this file is in no module"
    if other is None:
        return "this is no module of libpvol"
    return climbs(LIBRARY, own, other) and f"{own} does not see {other}"


def formats_target(name):
    """The module of formats/src that an include names, or None. One of them is called pvol."""
    public = name in ROOT_HEADERS or name.startswith("pvol/formats/") or library_target(name)
    first = name.split("/")[0]
    return first if first in FORMATS and not public else None


def check_formats(path, name, foreign):
    if foreign:
        return False
    if name.split("/")[0] in TOOLS:
        return "formats do not see tools"
    if library_target(name) and not name.startswith("pvol/"):
        return "formats see the library's public headers only"
    own = path.parts[path.parts.index("src") + 1] if "src" in path.parts else None
    other = formats_target(name)
    return own in FORMATS and other not in (None, own, "file") and f"{own} does not see {other}"


def check_tools(path, name, foreign):
    if foreign:
        return False
    own = path.parts[path.parts.index("tools") + 1]
    first = name.split("/")[0]
    if library_target(name) and not name.startswith("pvol/"):
        return "tools see the library's public headers only"
    if own in TOOLS and first in TOOLS:
        return climbs(TOOLS, own, first) and f"{own} does not see {first}"
    if first == "python" and own != "python":
        return "nothing but tests sees python"
    return first in ("tests", "support") and "nothing sees tests"


def find_climbing(project):
    checks = {"libpvol": check_library, "formats": check_formats, "tools": check_tools}
    found, lines = [], 0
    for top, check in checks.items():
        for path in sorted((project / top).rglob("*")):  # none where the folder is absent
            if path.suffix not in (".h", ".cpp", ".in") or not path.is_file():
                continue
            for number, line in enumerate(path.read_text().splitlines(), 1):
                include = INCLUDE.match(line)
                if not include:
                    continue
                lines += 1
                complaint = check(path.relative_to(project), include[1], include[2])
                if complaint:
                    found.append(f"{path.relative_to(project)}:{number}: {line.strip()}: {complaint}")
    return found, lines


PLANTED = {
    "libpvol/src/form/quadric.cpp": "pvol/bounds/pyramid.h",
    "libpvol/include/pvol/math/box.h": "pvol/form/quadric.h",
    "libpvol/src/shell/fit/adam.h": "volume/placement.h",
    "libpvol/include/pvol/embed.h": "pvol/render/scene.h",
    "libpvol/include/pvol/trackers.h": "pvol/render/film.h",
    "libpvol/include/pvol/track/field.h": "pvol/trackers.h",
    "libpvol/src/render/light/lights.cpp": "pvol/formats/image.h",
    "libpvol/src/render/film/film.cpp": "pvol/render/scene.h",
    "libpvol/src/render/scene/camera.cpp": "render/light/near_lights.h",
    "libpvol/src/render/path/outside_shell.h": "pvol/render/cost_map.h",
    "libpvol/include/pvol/render/lights.h": "pvol/render/plan.h",
    "libpvol/src/render/loose.cpp": "pvol/math/vec.h",
    "libpvol/src/density/noise.cpp": "<openvdb/openvdb.h>",
    "libpvol/src/stray.cpp": "pvol/math/vec.h",
    "formats/src/image/png.cpp": "toml/toml_table.h",
    "formats/src/vdb/vdb_read.cpp": "cli/cli.h",
    "formats/src/toml/scene_file.cpp": "render/engine/passes.h",
    "tools/report/html.cpp": "stats/trade_report.h",
    "tools/stats/stats_trade.cpp": "python/studies.h",
    "tools/python/rays.cpp": "volume/dense_bounds.h",
    "tools/pvol_fit.cpp": "support/statistics.h",
}


def self_test():
    """Each planted line alone in a project must be found."""
    for path, name in PLANTED.items():
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / path
            file.parent.mkdir(parents=True)
            file.write_text(f"#include {name}\n" if name[0] == "<" else f'#include "{name}"\n')
            found, _ = find_climbing(pathlib.Path(folder))
            assert len(found) == 1, f"{path} may include {name}"
    print(f"{len(PLANTED)} planted arrows found")


def main():
    if sys.argv[1:] == ["--self-test"]:
        return self_test()
    project = pathlib.Path(sys.argv[1])
    found, lines = find_climbing(project)
    print("\n".join(found))
    print(f"{lines} include lines, {len(found)} that climb")
    # A wrong folder has no include lines, and that is no proof.
    sys.exit(1 if found or lines < int(sys.argv[2] if len(sys.argv) > 2 else 1) else 0)


if __name__ == "__main__":
    main()
