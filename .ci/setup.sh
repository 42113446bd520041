#!/usr/bin/env bash
# Installs the Debian packages that pvol is built from, where any are missing; it takes milliseconds when
# everything is there.
#   .ci/setup.sh          for all that tests/run needs
#   .ci/setup.sh tools    for pvol-fit, pvol-render, pvol-view and pvol-convert, as samples/run needs
#   .ci/setup.sh nightly  for all that tests/nightly needs
#   .ci/setup.sh packages for all that tools/packages/make needs
set -euo pipefail

case ${1:-} in
  "" | tools | nightly | packages) ;;
  *)
    echo "set-up: error: found '$1', expected nothing, tools, nightly or packages" >&2
    exit 2
    ;;
esac

packages=(
  g++ cmake ninja-build pkg-config
  libtbb-dev libhwy-dev libembree-dev
  libopenvdb-dev libboost-iostreams-dev zlib1g-dev  # the last two are OpenVDB's, which forgets them
  libnanovdb-dev libblosc-dev                       # .nvdb files are often compressed with blosc
  libopenexr-dev libpng-dev
  libcli11-dev libfmt-dev libtomlplusplus-dev nlohmann-json3-dev libcpp-httplib-dev
  libzstd-dev libxxhash-dev
)
[[ ${1:-} == tools ]] || packages+=(
  ccache
  libcgal-dev                                       # the independent check of shells
  libopencolorio-dev                                # views of OCIO configurations
  libgtest-dev libbenchmark-dev python3             # python3 runs second readers of files
  pybind11-dev python3-dev python3-numpy            # the Python module
  openimageio-tools                                 # oiiotool reads pictures back in tests
  groff-base                                        # which sets the man pages
)
[[ ${1:-} != packages && ${1:-} != nightly ]] || packages+=(
  git dpkg-dev patchelf python3-pip python3-skbuild python3-venv
)
[[ ${1:-} != nightly ]] || packages+=(
  debootstrap                                       # a bare system for the packages
  python3-matplotlib                                # one of the module's examples
  slurmctld slurmd slurm-client munge               # a farm of one node
  cppcheck                                          # tests/analyse
  chromium chromium-driver python3-selenium         # the viewer's page in a browser
  blender xvfb xauth libgl1-mesa-dri                # the add-on, also with a window
)

if ! command -v apt-get >/dev/null || ! command -v dpkg-query >/dev/null; then
  echo "set-up: this is not a Debian-like system, so nothing is installed. The build needs what" \
    "these Debian 12 packages hold: ${packages[*]}" >&2
  exit 0
fi

missing=()
for package in "${packages[@]}"; do
  status=$(dpkg-query -W -f '${db:Status-Status}' "$package" 2>/dev/null || true)
  [[ $status == installed ]] || missing+=("$package")
done
if ((${#missing[@]} == 0)); then
  echo "set-up: all packages are installed"
  exit 0
fi

echo "set-up: installing ${missing[*]}"
as_root=()
if ((EUID != 0)); then
  if ! command -v sudo >/dev/null; then
    echo "set-up: error: installing packages needs root or sudo. As root, run:" \
      "apt-get update && apt-get install --no-install-recommends ${missing[*]}" >&2
    exit 1
  fi
  as_root=(sudo)
fi
apt=("${as_root[@]}" env DEBIAN_FRONTEND=noninteractive
  apt-get -q -o DPkg::Lock::Timeout=300)
"${apt[@]}" update
"${apt[@]}" install --yes --no-install-recommends "${missing[@]}"
