#!/usr/bin/env python3
"""Cost at equal noise of scenes of every kind, two programs in turn in one run, on one thread.

    tests/bench/scenes.py OLD NEW CLOUDS [--rounds 3] [--size 160x90] [--spp 16] [--case NAME]...

OLD and NEW are two programs, pvol-render; CLOUDS is a folder with cumulus_448.vdb, wdas_cloud_sixteenth.vdb and smoke1.vdb. Prints for each scene the kernel
of the new program, and of new over old

  time    CPU time of rendering, the least of the rounds: without loading, with the guide
  E       time x mean variance of a pixel
  rel     time x mean over the pixels of variance / (mean^2 + (1 % of the picture's mean)^2)

kernels.py builds the program of another revision. Pixels are boxes, as those of old programs are."""
import argparse
import json
import pathlib
import struct
import subprocess
import sys
import tempfile
import zlib

SAMPLES = pathlib.Path(__file__).resolve().parents[2] / "samples"
SUN = '[[sun]]\ndirection = [-0.5, 0.6, 0.4]\nirradiance = [3.3, 3.0, 2.6]\nangle = 0.53\n'
CLOUD = '[volume]\nfile = "{clouds}/{file}"\n[medium]\nextinction = {extinction}\nalbedo = 0.999\ng = {g}\n'
PLANE = '[[plane]]\npoint = [0, {height}, 0]\nalbedo = 0.2\n'
LAMPS = """[[spot]]
position = [60, 120, 60]
direction = [-1, -1.2, -1]
intensity = [9e4, 7e4, 3e4]
angle = 40
[[area]]
position = [-60, 40, 0]
direction = [1, 0, 0]
size = [40, 40]
radiance = [3, 4, 6]
[[point]]
position = [-10, 30, 0]
intensity = [400, 300, 900]
radius = 2
"""


def cloud(file, extinction, more="", g=0.85):
    return CLOUD.replace("{file}", file).replace("{extinction}", str(extinction)).replace("{g}", str(g)) + more


def instances(number):
    """A sky of so many small copies of the sample cumulus, side by side."""
    along = max(1, round(number ** 0.5))
    text = '[volume]\nfile = "{samples}/cumulus.toml"\n[medium]\nextinction = 30\nalbedo = 0.999\ng = 0.85\n'
    for k in range(number):
        x, z = k % along - along / 2, k // along - along / 2
        text += f"[[volume.instance]]\nscale = 0.5\nrotate = [0, 1, 0, {37 * k % 360}]\n"
        text += f"translate = [{2 * x}, 0, {2 * z}]\n"
    return text + SUN


# Scenes by name: a sample, or the text of a scene, and options.
CASES = {
    "ground": ("ground.toml", []),
    "cumulus_448 over a plane": (cloud("cumulus_448.vdb", 8, PLANE.replace("{height}", "-2") + SUN), []),
    "two_smokes": ("two_smokes.toml", []),
    "sky of 100": (instances(100), []),
    "sky of 1000": (instances(1000), []),
    "campfire": ("campfire.toml", []),
    "fog_fire": ("fog_fire.toml", []),
    "coloured_smoke": ("coloured_smoke.toml", []),
    "lamps": ("lamps.toml", []),
    "lamps in smoke": (cloud("smoke1.vdb", 3, LAMPS), []),
    "tricubic": (cloud("wdas_cloud_sixteenth.vdb", 0.3, SUN), ["--interpolation", "tricubic"]),
    "ramp": (cloud("smoke1.vdb", 3, SUN), ["--set", "medium.density.ramp=[[0,0],[0.3,0],[1,1]]"]),
    "extinction by channel": (cloud("wdas_cloud_sixteenth.vdb", 0.3, SUN),
                              ["--set", "medium.extinction_color=[1,0.8,0.6]"]),
    "moving_plume": ("moving_plume.toml", []),
    "one cloud": (cloud("wdas_cloud_sixteenth.vdb", 0.3, SUN), []),
}


def read_exr(file):
    """The channels of a picture in scan lines, each a list of floats, by name."""
    data = file.read_bytes()
    at, attributes = 8, {}

    def text():
        nonlocal at
        end = data.index(b"\0", at)
        word, at = data[at:end].decode(), end + 1
        return word

    while data[at]:
        name, _ = text(), text()
        size, = struct.unpack_from("<i", data, at)
        attributes[name] = data[at + 4:at + 4 + size]
        at += 4 + size
    at += 1
    channels, place, table = [], 0, attributes["channels"]
    while table[place]:
        end = table.index(b"\0", place)
        kind, = struct.unpack_from("<i", table, end + 1)
        channels.append((table[place:end].decode(), "Ief"[kind], (4, 2, 4)[kind]))
        place = end + 17
    x0, y0, x1, y1 = struct.unpack("<4i", attributes["dataWindow"])
    width, height = x1 - x0 + 1, y1 - y0 + 1
    lines = 16 if attributes["compression"] == b"\3" else 1
    planes = {name: [] for name, _, _ in channels}
    offsets = struct.unpack_from(f"<{-(-height // lines)}Q", data, at)
    for offset in offsets:
        y, size = struct.unpack_from("<2i", data, offset)
        count = min(lines, y1 - y + 1)
        raw = data[offset + 8:offset + 8 + size]
        if size < count * width * sum(c[2] for c in channels):
            raw = undo_predictor(zlib.decompress(raw))
        place = 0
        for _ in range(count):
            for name, kind, bytes_each in channels:
                planes[name].extend(struct.unpack_from(f"<{width}{kind}", raw, place))
                place += width * bytes_each
    return planes


def undo_predictor(coded):
    """Bytes as they were before ZIP compression: differences are summed, and two halves are shuffled."""
    out, last = bytearray(coded), coded[0]
    for i in range(1, len(coded)):
        last = (last + coded[i] - 128) & 255
        out[i] = last
    half = (len(out) + 1) // 2
    raw = bytearray(len(out))
    raw[0::2], raw[1::2] = out[:half], out[half:]
    return bytes(raw)


def beside_brightness(squares, values):
    """The mean of squared errors, each over the square of its value plus that of 1 % of the mean value."""
    floor = (0.01 * sum(values) / len(values)) ** 2
    return sum(s / (v * v + floor) for s, v in zip(squares, values)) / len(values)


def noise_of(picture):
    """The mean variance of a pixel, and the mean relative one."""
    planes = read_exr(picture)
    variance = [sum(v) / 3 for v in zip(*(planes["variance." + c] for c in "RGB"))]
    value = [sum(v) / 3 for v in zip(*(planes[c] for c in "RGB"))]
    return sum(variance) / len(variance), beside_brightness(variance, value)


def render(program, scene, options, folder):
    """CPU seconds of rendering, variance, relative variance, kernel; none where the program refuses."""
    picture, stats = folder / "a.exr", folder / "a.json"
    command = [program, scene, "-o", picture, "--stats", stats, "--threads", "1", "--aov", "variance,samples",
               "--no-png", "--quiet", "--filter", "box", *options]
    run = subprocess.run([str(c) for c in command], capture_output=True, text=True)
    if run.returncode:
        return None, run.stderr.strip().splitlines()[0]
    report = json.loads(stats.read_text())
    return (report["cpu_seconds"], *noise_of(picture)), report["options"]["kernel_used"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("old")
    parser.add_argument("new")
    parser.add_argument("clouds", type=pathlib.Path)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--size", default="160x90")
    parser.add_argument("--spp", default="16")
    parser.add_argument("--case", action="append", choices=CASES)
    given = parser.parse_args()
    print(f"{'scene':26} {'kernel':8} {'time':>6} {'E':>6} {'rel':>6}   CPU s of old and new")
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        for case in given.case or CASES:
            text, options = CASES[case]
            scene = SAMPLES / text
            if not text.endswith(".toml"):
                scene = folder / "scene.toml"
                text = text.replace("{clouds}", str(given.clouds.resolve()))
                scene.write_text(text.replace("{samples}", str(SAMPLES)))
            options = [*options, "--size", given.size, "--spp", given.spp]
            best = {}
            for _ in range(given.rounds):
                for program in (given.old, given.new):
                    figures, kernel = render(program, scene, options, folder)
                    if figures is None:
                        best[program] = None, kernel
                    elif program not in best or figures[0] < best[program][0][0]:
                        best[program] = figures, kernel
            (a, why_a), (b, why_b) = best[given.old], best[given.new]
            if a is None or b is None:
                print(f"{case:26} {why_a if a is None else why_b}")
                continue
            time = b[0] / a[0]
            print(f"{case:26} {why_b:8} {time:6.2f} {time * b[1] / a[1]:6.2f} {time * b[2] / a[2]:6.2f}   "
                  f"{a[0]:.3f} {b[0]:.3f}", flush=True)


if __name__ == "__main__":
    sys.exit(main())
