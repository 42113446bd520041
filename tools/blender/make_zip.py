#!/usr/bin/env python3
"""Packs the add-on into pvol_blender.zip, which Blender installs: Edit > Preferences > Add-ons >
Install.

With --module the compiled Python module goes into the zip, so that nothing else is to be installed.
It must be built for the Python of the Blender that it is for."""

import argparse
import pathlib
import re
import sys
import zipfile

ADDON = pathlib.Path(__file__).resolve().parent / "pvol_blender"
PROJECT = ADDON.parents[2] / "CMakeLists.txt"  # which has the version


def module_files(folder):
    """The package pvol in `folder`, or `folder` itself, with its compiled module."""
    package = folder / "pvol" if (folder / "pvol").is_dir() else folder
    if package.name != "pvol" or not list(package.glob("_pvol*")):
        sys.exit(f"make_zip.py: --module {folder}: found no package pvol with a compiled module "
                 "(_pvol*.so) there; give the folder that contains it, such as build/ci/python")
    return [(f, f"modules/pvol/{f.name}") for f in sorted(package.iterdir()) if f.is_file()]


def text_of(source):
    """A file of the add-on; in bl_info, which Blender reads as a literal, with pvol's version."""
    text = source.read_text()
    version = re.search(r"project\(pvol VERSION (\d+)\.(\d+)\.(\d+)", PROJECT.read_text())
    return re.sub(r'"version": \([^)]*\)', f'"version": ({", ".join(version.groups())})', text)


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-o", "--output", type=pathlib.Path, metavar="FILE",
                        default=pathlib.Path("pvol_blender.zip"))
    parser.add_argument("--module", type=pathlib.Path, metavar="DIR",
                        help="folder that contains the package pvol (build/ci/python)")
    options = parser.parse_args()
    files = [(f, str(f.relative_to(ADDON))) for f in sorted(ADDON.rglob("*.py"))
             if "modules" not in f.relative_to(ADDON).parts]
    if options.module:
        files += module_files(options.module)
    with zipfile.ZipFile(options.output, "w", zipfile.ZIP_DEFLATED) as pack:
        for source, name in files:
            content = text_of(source) if source == ADDON / "__init__.py" else source.read_bytes()
            pack.writestr(f"pvol_blender/{name}", content)
    print(f"{options.output}: {len(files)} files")


if __name__ == "__main__":
    main()
