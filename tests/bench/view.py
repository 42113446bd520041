#!/usr/bin/env python3
"""How soon pvol-view shows a picture, beside pvol-render of the same one.

view.py TOOLS CLOUD [SIZE]     e.g. view.py build/release/tools cloud.vdb 640x360

Prints, as medians of five rounds in turn: seconds from the start of the tool to its address; from a change of
the camera, of the albedo and of the extinction to the first picture, to the first one of all pixels and to the
last sample; and the wall time of pvol-render for the same picture, its start and the cloud's loading included.
"""
import json
import statistics
import subprocess
import sys
import tempfile
import time
import urllib.request

SPP = 16
EDITS = {
    "camera": lambda i: {"section": "camera", "key": "fov", "value": 35 + 0.1 * i},
    "albedo": lambda i: {"section": "volume[1].medium", "key": "albedo", "value": 0.999 - 1e-5 * i},
    "extinction": lambda i: {"section": "volume[1].medium", "key": "extinction", "value": 80 + 0.1 * i},
}


def ask(address, path, body=None):
    data = None if body is None else json.dumps(body).encode()
    with urllib.request.urlopen(urllib.request.Request(address + path, data=data)) as answer:
        return json.loads(answer.read())


def follow(address, change):
    """Seconds to the first picture, the first whole one and the end, from a change."""
    before = ask(address, "state?after=0")
    begin = time.monotonic()
    ask(address, "scene", {"edits": [change]})
    state, first, whole = before, None, None
    while not (state["change"] > before["change"] and state["finished"]):
        state = ask(address, f"state?after={state['number']}")
        if state["change"] == before["change"]:
            continue
        now = time.monotonic() - begin
        first = first or now
        whole = whole or (None if state["coarse"] else now)
    return first, whole, time.monotonic() - begin


def main(tools, cloud, size="640x360"):
    options = ["--size", size, "--spp", str(SPP), "--quiet"]
    begin = time.monotonic()
    viewer = subprocess.Popen([f"{tools}/pvol-view", cloud, *options], stdout=subprocess.PIPE, text=True)
    address = viewer.stdout.readline().strip()
    opened = time.monotonic() - begin
    try:
        times = {name: [] for name in EDITS}
        renders = []
        for i in range(5):
            for name, edit in EDITS.items():
                times[name].append(follow(address, edit(i)))
            with tempfile.TemporaryDirectory() as folder:
                begin = time.monotonic()
                subprocess.run([f"{tools}/pvol-render", cloud, "-o", f"{folder}/a.png", *options], check=True)
                renders.append(time.monotonic() - begin)
    finally:
        viewer.terminate()
    print(f"{size}, {SPP} samples per pixel, seconds")
    print(f"  address {opened:.2f}")
    for name, rows in times.items():
        first, whole, last = (statistics.median(column) for column in zip(*rows))
        print(f"  {name:<11} first picture {first:.3f}, all pixels {whole:.3f}, done {last:.2f}")
    print(f"  pvol-render {statistics.median(renders):.2f}")


if __name__ == "__main__":
    main(*sys.argv[1:])
