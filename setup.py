"""The Python module as a wheel: CMake builds and installs it, scikit-build puts it into the wheel."""

import pathlib
import re
import sys

from skbuild import setup

HERE = pathlib.Path(__file__).parent
VERSION = re.search(r"project\(pvol VERSION ([0-9.]+)", (HERE / "CMakeLists.txt").read_text())[1]
FOLDER = "tools/python"  # of the package's sources, where scikit-build looks for what is installed


def of_the_package(files):
    """Of all that CMake installs, the package, with the module for OpenVDB."""
    return [file for file in files if f"{FOLDER}/pvol/" in file.replace("\\", "/")]


setup(
    name="pvol",
    version=VERSION,
    description="Clouds, smoke and fire: volumes, rays and pictures by unbiased path tracing",
    license="Apache-2.0",
    packages=["pvol"],
    package_dir={"": FOLDER},
    package_data={"pvol": ["*.pyi", "py.typed"]},
    python_requires=">=3.9",
    install_requires=["numpy"],
    cmake_args=[
        f"-DPython3_EXECUTABLE={sys.executable}",
        f"-DPVOL_PYTHON_DIR={FOLDER}",
        f"-DPVOL_MODULE_DIR={FOLDER}/pvol",
        "-DPVOL_BUILD_TESTS=OFF",
        "-DPVOL_BUILD_STATS=OFF",
        "-DPVOL_BUILD_VIEW=OFF",
        "-DPVOL_WITH_CGAL=OFF",
        "-DCMAKE_UNITY_BUILD=ON",
    ],
    cmake_process_manifest_hook=of_the_package,
)
