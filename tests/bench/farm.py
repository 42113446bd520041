#!/usr/bin/env python3
"""What bounds a render on many machines: measures, and a simulation that takes what was measured.

    farm.py load CLOUD.vdb...          bytes and seconds until a cloud can be rendered, by its file
    farm.py guide CLOUD...             what each part pays for guided paths before its first sample
    farm.py parts SCENE N [OPTION...]  CPU seconds of each of N parts against their forecast
    farm.py merge WHOLE.parts N        bytes and seconds of a merge of finished parts
    farm.py simulate [parts.json...]   efficiency at 10, 100 and 1000 parts

The tools are those in $PVOL_TOOLS, or else on the path. `parts` prints JSON on stdout, for `simulate`,
and a summary on stderr.
"""
import argparse
import heapq
import json
import os
import pathlib
import random
import statistics
import subprocess
import sys
import tempfile
import time


def tool(name):
    folder = os.environ.get("PVOL_TOOLS")
    return str(pathlib.Path(folder) / name) if folder else name


def run(*command, **more):
    """What a command prints, the seconds it takes on the clock, and those of the processor."""
    before, begin = os.times(), time.monotonic()
    done = subprocess.run([str(word) for word in command], text=True, stdout=subprocess.PIPE,
                          stderr=subprocess.PIPE, **more)
    seconds, after = time.monotonic() - begin, os.times()
    if done.returncode != 0:
        sys.exit(f"{command}: status {done.returncode}\n{done.stderr}")
    cpu = after.children_user + after.children_system - before.children_user - before.children_system
    return done.stdout, seconds, cpu


def least(count, measure):
    """The run of least CPU time of so many: others had the machine to share."""
    return min((measure() for _ in range(count)), key=lambda r: r[2])


# --- loading ------------------------------------------------------------------------------------

def bytes_read(*files):
    return sum(os.path.getsize(file) for file in files)


def load(args):
    one_sample = ["--size", "1x1", "--spp", "1", "--no-png", "--quiet", "--force"]
    print(f"{'cloud':28} {'file':22} {'bytes read':>12} {'CPU s':>7}")
    with tempfile.TemporaryDirectory() as folder:
        for cloud in args.clouds:
            files = {".vdb itself": ([], None)}
            for label, options in ((".pvol, by reference", ["--density", "reference"]),
                                   (".pvol, exact", []), (".pvol, fp16", ["--density", "fp16"]),
                                   (".pvol, fp8", ["--density", "fp8"])):
                made = pathlib.Path(folder) / f"{len(files)}.pvol"
                run(tool("pvol-fit"), pathlib.Path(cloud).resolve(), "-o", made, *options, "--quiet")
                files[label] = (options, made)
            for label, (options, made) in files.items():
                file = made or cloud
                read = [cloud, made] if "reference" in label else [file]
                out = pathlib.Path(folder) / "one.exr"
                _, _, cpu = least(3, lambda: run(tool("pvol-render"), file, "-o", out, *one_sample))
                print(f"{pathlib.Path(cloud).stem:28} {label:22} {bytes_read(*read):12} {cpu:7.2f}")


# --- guiding ------------------------------------------------------------------------------------

def guide(args):
    print(f"{'cloud':28} {'CPU s without':>13} {'with':>7} {'difference':>10}")
    with tempfile.TemporaryDirectory() as folder:
        for cloud in args.clouds:
            few = ["--size", "640x480", "--crop", "320,240,1,1", "--spp", "1", "--no-png", "--quiet",
                   "-o", pathlib.Path(folder) / "one.exr"]
            off, on = (least(3, lambda: run(tool("pvol-render"), cloud, *few, "--guide", word))[2]
                       for word in ("off", "on"))
            print(f"{pathlib.Path(cloud).stem:28} {off:13.2f} {on:7.2f} {on - off:10.2f}")


# --- parts --------------------------------------------------------------------------------------

def without(command, *dropped):
    """A command without these options, each with its value."""
    words = iter(command)
    return [w for w in words if not (w in dropped and next(words))]


def parts(args):
    with tempfile.TemporaryDirectory() as folder:
        whole = pathlib.Path(folder) / "whole.exr"
        text, _, planning = run(tool("pvol-render"), args.scene, "-o", whole, *args.options, "--split",
                                args.count, "--for", "json", "--quiet")
        split = json.loads(text)
        rows = []
        for part in split["parts"]:
            first, end = part["samples"]
            stats = pathlib.Path(folder) / "stats.json"
            command = without(part["command"], "--samples", "--checkpoint", "--sums", "--spp", "-o")
            command.remove("--resume")
            _, _, all_of_it = run(*command, "--spp", end - first, "--first-sample", first, "-o",
                                  pathlib.Path(folder) / "part.exr", "--stats", stats, "--threads", 1,
                                  "--quiet")
            render = json.loads(stats.read_text())["cpu_seconds"]
            rows.append({"share": part["share"], "crop": part["crop"], "cpu_seconds": render,
                         "overhead_seconds": all_of_it - render})
            print(f"\r{len(rows)} of {args.count}", end="", file=sys.stderr)
    render = [r["cpu_seconds"] for r in rows]
    mean = statistics.mean(render)
    forecast = [r["share"] * len(rows) for r in rows]
    print(f"\r{args.scene}: {len(rows)} parts, split in {planning:.2f} s of CPU time; "
          f"each {mean:.3f} s on average to render and "
          f"{statistics.mean(r['overhead_seconds'] for r in rows):.3f} s besides; "
          f"{sum(render):.1f} s in all, {split['cpu_seconds']:.1f} s by forecast", file=sys.stderr)
    print(f"over the mean: the largest {max(render) / mean:.3f}, the smallest "
          f"{min(render) / mean:.3f}, standard deviation {statistics.pstdev(render) / mean:.3f}; "
          f"the largest by forecast {max(forecast):.3f}", file=sys.stderr)
    json.dump({"scene": args.scene, "options": args.options, "parts": rows}, sys.stdout, indent=1)


# --- merging ------------------------------------------------------------------------------------

def merge(args):
    files = sorted(pathlib.Path(args.folder).glob(f"part.*-of-{args.count:04}.exr"))
    with tempfile.TemporaryDirectory() as folder:
        out = pathlib.Path(folder) / "whole.exr"
        _, seconds, cpu = run(tool("pvol-convert"), "merge", *files, "-o", out, "--no-png")
        print(f"{len(files)} parts of {bytes_read(*files)} bytes: {cpu:.2f} s of CPU time, "
              f"{seconds:.2f} s on the clock; {os.path.getsize(out)} bytes written")


# --- simulation ---------------------------------------------------------------------------------

def relative_times(files):
    """Measured times of parts over their mean, of all files together."""
    times = []
    for file in files:
        render = [r["cpu_seconds"] for r in json.loads(pathlib.Path(file).read_text())["parts"]]
        mean = statistics.mean(render)
        times += [t / mean for t in render]
    return times


def simulate_once(rng, ratios, nodes, per_node, args):
    """Seconds of work, and of the clock from the first task to the merged picture.

    Nodes take parts from one queue, so that a fast one does more. The first part of each node loads
    the cloud from the shared storage, all nodes at once; later ones find the local copy. A task that
    fails is begun again from its last checkpoint."""
    count = nodes * per_node
    shared = args.cloud_bytes * nodes / args.bandwidth
    speed = [max(0.5, rng.gauss(1, args.uneven)) for _ in range(nodes)]
    free = [(0.0, node) for node in range(nodes)]
    loaded, work, end = set(), 0.0, 0.0
    for _ in range(count):
        now, node = heapq.heappop(free)
        seconds = args.part_seconds / per_node * rng.choice(ratios)
        work += seconds
        lost = 0.0
        while rng.random() < args.failures:
            lost += rng.uniform(0, min(args.checkpoint, seconds)) + args.requeue
        load = args.load + (0 if node in loaded else max(0, shared - args.load))
        loaded.add(node)
        now += args.start + load + args.guide + (seconds + lost) / speed[node]
        end = max(end, now)
        heapq.heappush(free, (now, node))
    film = args.pixels * args.bytes_per_pixel * max(1, count / args.most_rectangles)
    merging = args.start + args.merge_seconds * film / 1e9 + film / args.bandwidth
    return work, end + merging


def without_costs(args, *names):
    """The same with these causes of loss left out."""
    return argparse.Namespace(**{**vars(args), **{name: 0 for name in names}})


CASES = [  # each with what is left out of it
    ("uneven parts alone", ["start", "load", "cloud_bytes", "guide", "uneven", "failures",
                            "merge_seconds", "bytes_per_pixel"]),
    ("and uneven nodes", ["start", "load", "cloud_bytes", "guide", "failures", "merge_seconds",
                          "bytes_per_pixel"]),
    ("and start, guide, load from a local disk", ["cloud_bytes", "failures", "merge_seconds",
                                                  "bytes_per_pixel"]),
    ("and load over the network", ["failures", "merge_seconds", "bytes_per_pixel"]),
    ("and failures", ["merge_seconds", "bytes_per_pixel"]),
    ("and the merge, others waiting", []),
]


def simulate(args):
    ratios = relative_times(args.files) if args.files else [1.0]
    print(f"{len(ratios)} measured parts: the largest {max(ratios):.3f} times the mean, standard "
          f"deviation {statistics.pstdev(ratios):.3f}; {args.part_seconds:g} s of work for each node "
          f"in {args.per_node} part{'s' if args.per_node > 1 else ''}")
    print(f"{'efficiency with':42}" + "".join(f"{n:>6} nodes" for n in args.nodes))
    for name, left_out in CASES:
        cells = []
        for nodes in args.nodes:
            rng = random.Random(args.seed)
            runs = [simulate_once(rng, ratios, nodes, args.per_node, without_costs(args, *left_out))
                    for _ in range(50)]
            cells.append(sum(work for work, _ in runs) / (nodes * sum(clock for _, clock in runs)))
        print(f"{name:42}" + "".join(f"{c:12.3f}" for c in cells))


def main():
    app = argparse.ArgumentParser(description=__doc__,
                                  formatter_class=argparse.RawDescriptionHelpFormatter)
    verbs = app.add_subparsers(required=True)
    for name, work in (("load", load), ("guide", guide)):
        verb = verbs.add_parser(name)
        verb.add_argument("clouds", nargs="+")
        verb.set_defaults(work=work)
    verb = verbs.add_parser("parts")
    verb.add_argument("scene")
    verb.add_argument("count", type=int)
    verb.add_argument("options", nargs=argparse.REMAINDER)
    verb.set_defaults(work=parts)
    verb = verbs.add_parser("merge")
    verb.add_argument("folder")
    verb.add_argument("count", type=int)
    verb.set_defaults(work=merge)
    verb = verbs.add_parser("simulate")
    verb.add_argument("files", nargs="*")
    verb.add_argument("--nodes", type=int, nargs="+", default=[10, 100, 1000])
    verb.add_argument("--per-node", type=int, default=1, help="parts for each node [%(default)s]")
    for name, value, about in (
            ("part-seconds", 60, "of work for each node"),
            ("start", 0.3, "seconds in which a queue starts a task"),
            ("load", 0.5, "seconds to load a cloud from a local disk"),
            ("cloud-bytes", 30.6e6, "of the cloud"),
            ("bandwidth", 2e9, "bytes a second of the shared storage, for all nodes together"),
            ("guide", 0.1, "seconds of the guide's pre-pass of each part"),
            ("uneven", 0.02, "standard deviation of the nodes' speeds"),
            ("failures", 0.0, "probability that a task fails"),
            ("checkpoint", 600, "seconds between checkpoints"),
            ("requeue", 10, "seconds until a failed task runs again"),
            ("pixels", 1920 * 1080, "of the picture"),
            ("bytes-per-pixel", 49, "of exact sums in a part's file"),
            ("most-rectangles", 8100, "into which it is cut before samples are: 16 x 16 pixels"),
            ("merge-seconds", 56, "of CPU time to merge 10^9 bytes"),
            ("seed", 1, "of the simulation")):
        verb.add_argument(f"--{name}", type=type(value), default=value,
                          help=f"{about} [%(default)s]")
    verb.set_defaults(work=simulate)
    args = app.parse_args()
    args.work(args)


if __name__ == "__main__":
    main()
