#!/usr/bin/env python3
"""Reads a .pvol file as formats/FORMAT.md describes it, with Python's standard library alone, and
prints what it holds. An independent second reader: the test compares its print with pvol's own.

    read_pvol.py FILE.pvol

Compressed chunks need the zstd command. Checksums are verified where the xxhash module is there."""
import json
import shutil
import struct
import subprocess
import sys

try:
    import xxhash
except ImportError:
    xxhash = None


def require(condition, sentence):
    if not condition:
        sys.exit(f"{sys.argv[1]}: {sentence}")


def read_container(data):
    """Header and chunk table: id -> (codec, stored bytes, raw size)."""
    magic, version, reader, size, count, reserved, checksum = struct.unpack_from("<8sIIQIIQ", data)
    require(magic == b"\x89PVL\r\n\x1a\n", "not a .pvol file")
    require(reader <= 3, "needs a newer reader")
    require(size == len(data), "truncated")
    table_end = 40 + 40 * count
    if xxhash:
        head = data[:32] + bytes(8) + data[40:table_end]
        require(xxhash.xxh3_64_intdigest(head) == checksum, "wrong checksum of the header")
    print("version", version)
    chunks, end = {}, table_end
    for i in range(count):
        name, codec, offset, stored, raw, checksum = struct.unpack_from("<4sIQQQQ", data, 40 + 40 * i)
        require(offset == (end + 63) // 64 * 64, "chunks do not follow each other")
        require(not any(data[end:offset]), "the padding is not zero")
        end = offset + stored
        payload = data[offset:end]
        if xxhash:
            require(xxhash.xxh3_64_intdigest(payload) == checksum, "wrong checksum of a chunk")
        chunks.setdefault(name, []).append((codec, payload, raw))
        print("chunk", name.decode(), codec, offset, stored, raw)
    require(end == len(data), "bytes after the last chunk")
    for name, found in chunks.items():
        require(len(found) == 1 or name == b"fild", f"{name} is there several times")
    return {name: found if name == b"fild" else found[0] for name, found in chunks.items()}


def raw_bytes(chunk):
    codec, payload, raw = chunk
    if codec == 0:
        return payload
    require(shutil.which("zstd"), "the file is compressed and there is no zstd command")
    data = subprocess.run(["zstd", "-dcq"], input=payload, capture_output=True, check=True).stdout
    require(len(data) == raw, "wrong size after decompression")
    if codec == 1:
        return data
    out = bytearray()
    for start in range(0, raw, 1 << 20):
        frame = data[start:start + (1 << 20)]
        words = len(frame) // 4
        block = bytearray(len(frame))
        for plane in range(4):
            block[plane::4] = frame[plane * words:(plane + 1) * words]
        out += block
    return bytes(out)


def morton_decode(code):
    at = [0, 0, 0]
    for bit in range(21):
        for axis in range(3):
            at[axis] |= (code >> 3 * bit + axis & 1) << bit
    return at


def decode_bound(code, scale):
    e, m = code >> 11, code & 2047
    units = m if e == 0 else 2048 + m << e - 1
    return struct.unpack("<f", struct.pack("<f", units * scale / 2**41))[0]


def f32(value):
    """The nearest 32-bit float."""
    return struct.unpack("<f", struct.pack("<f", value))[0]


def print_bounds(raw):
    """Returns the corners of the leaves, in the order of the file."""
    *box, scale, levels, upper, lower, terminals = struct.unpack_from("<9ifIIII", raw)
    print("origin", *box[0:3])
    print("support", *box[3:9])
    print("scale", f"{scale:.9g}")
    print("levels", levels)
    nodes = upper + lower
    layout = f"<{nodes}Q{upper}Q{terminals}H{terminals}H{nodes}B"
    require(len(raw) == 56 + struct.calcsize(layout), "wrong size of BNDS")
    values = iter(struct.unpack_from(layout, raw, 56))
    take = lambda n: [next(values) for _ in range(n)]
    children, stops = take(nodes), take(upper)
    lo, hi, groups = take(terminals), take(terminals), take(nodes)
    codes, node, cubes = [0] if levels else [], 0, []
    for height in range((levels - 1) // 2, -1, -1):
        inner = []
        for code in codes:
            stop = stops[node] if height > 0 else children[node]
            for g in range(8):
                found = []
                if groups[node] >> g & 1:
                    found.append((2 * height + 1, 8 * code + g))
                for b in range(8 * g, 8 * g + 8):
                    if children[node] >> b & 1:
                        if stop >> b & 1:
                            found.append((2 * height, 64 * code + b))
                        else:
                            inner.append(64 * code + b)
                for level, cube in found:
                    bounds = [decode_bound(v[len(cubes)], scale) for v in (lo, hi)]
                    cubes.append((level, cube, bounds))
            node += 1
        codes = inner
    require((node, len(cubes)) == (nodes, terminals), "wrong number of nodes or terminals")
    corner = lambda level, cube: [box[i] + (v << level + 3) for i, v in enumerate(morton_decode(cube))]
    for level, cube, bounds in sorted(cubes):
        print("terminal", level, *corner(level, cube), *(f"{v:.9g}" for v in bounds))
    return [corner(0, cube) for level, cube, _ in cubes if level == 0]


def print_micro(raw, leaves):
    """Returns (corner, bounds) of every cube of 2^3 cells."""
    edge, count, open_count, _ = struct.unpack_from("<IIII", raw)
    layout = f"<{count}f{count}f{64 * open_count}B{64 * open_count}B"
    require((edge, count) == (2, len(leaves)), "micr belongs to other bounds")
    require(len(raw) == 16 + struct.calcsize(layout), "wrong size of micr")
    values = struct.unpack_from(layout, raw, 16)
    base, step, codes = values[:count], values[count:2 * count], values[2 * count:]
    at, cubes = 0, []
    for leaf, corner in enumerate(leaves):
        pairs = [(0, 0)] * 64
        if step[leaf] > 0:
            pairs = [(codes[i], codes[64 * open_count + i]) for i in range(at, at + 64)]
            at += 64
        bound = lambda code: f32(base[leaf] + f32(code * step[leaf]))
        bounds = [(bound(lo), bound(hi)) for lo, hi in pairs]
        print("micro", *corner, *(f"{v:.9g}" for pair in bounds for v in pair))
        for i, pair in enumerate(bounds):
            at_cube = (i >> 4, i >> 2 & 3, i & 3)
            cubes.append(([c + 2 * a for c, a in zip(corner, at_cube)], pair))
    require(at == 64 * open_count, "wrong number of leaves with codes")
    return cubes


def check_micro(cubes, bricks, tiles):
    """Micro-bounds against the samples that interpolation reads."""
    edges = {edge for *_, edge, _ in tiles}
    tile_at = {tuple(tile[:4]): tile[4] for tile in tiles}

    def sample(x, y, z):
        brick = bricks.get((x & -8, y & -8, z & -8))
        if brick:
            return brick[((x & 7) * 8 + (y & 7)) * 8 + (z & 7)]
        found = (tile_at.get((x & -e, y & -e, z & -e, e)) for e in edges)
        return next((v for v in found if v is not None), 0.0)

    for (x, y, z), (lo, hi) in cubes:
        near = [sample(x + i // 9, y + i // 3 % 3, z + i % 3) for i in range(27)]
        require(lo <= min(near) and max(near) <= hi, f"micro-bounds at {x} {y} {z} do not hold")


def print_shell(raw):
    kind, count, bound, boxes, depth, _, *ratios = struct.unpack_from("<IIdQiI4f", raw)
    require(len(raw) == 88 + 44 * count, "wrong size of shel")
    numbers = lambda values: [f"{v:.9g}" for v in values]
    print("shell", ("hard", "soft")[kind], f"{bound:.17g}", boxes, depth, *numbers(ratios))
    print("base", *numbers(struct.unpack_from("<10f", raw, 48)))
    for i in range(count):
        print("perturbation", *numbers(struct.unpack_from("<11f", raw, 88 + 44 * i)))


def print_blocks(raw, at, tiles, bricks, samples_of):
    """Tiles and origins from byte `at` on; samples_of(i) are those of brick i."""
    all_tiles, all_bricks = [], {}
    for i in range(tiles):
        *tile, value = struct.unpack_from("<4if", raw, at + 20 * i)
        print("tile", *tile, f"{value:.9g}")
        all_tiles.append((*tile, value))
    for i in range(bricks):
        origin = struct.unpack_from("<3i", raw, at + 20 * tiles + 12 * i)
        samples = samples_of(i)
        print("brick", *origin, *(f"{v:.9g}" for v in samples))
        all_bricks[origin] = samples
    return all_bricks, all_tiles


def print_density(raw):
    tiles, bricks = struct.unpack_from("<II", raw)
    require(len(raw) == 8 + 20 * tiles + 2060 * bricks, "wrong size of DENS")
    samples = 8 + 20 * tiles + 12 * bricks
    samples_of = lambda i: struct.unpack_from("<512f", raw, samples + 2048 * i)
    return print_blocks(raw, 8, tiles, bricks, samples_of)


def print_quantised(raw, meta):
    precision, exponent, tiles, bricks = struct.unpack_from("<IiII", raw)
    names = {1: "fp16", 2: "fp8", 3: "fpn"}
    require(names[precision] == meta["density"]["precision"], "META tells of another precision")
    print("precision", names[precision])
    at = 16 + 20 * tiles + 12 * bricks
    if precision == 1:
        require(len(raw) == at + 1024 * bricks, "wrong size of DENQ")
        halves = lambda i: struct.unpack_from("<512e", raw, at + 1024 * i)
        samples_of = lambda i: [f32(v * 2.0**exponent) for v in halves(i)]
        return print_blocks(raw, 16, tiles, bricks, samples_of)
    lo = struct.unpack_from(f"<{bricks}f", raw, at)
    hi = struct.unpack_from(f"<{bricks}f", raw, at + 4 * bricks)
    widths = raw[at + 8 * bricks:at + 9 * bricks]
    start = [at + 8 * bricks + (bricks + 3) // 4 * 4]
    for width in widths:
        start.append(start[-1] + 64 * (width & 127))
    require(len(raw) == start[-1], "wrong size of DENQ")

    def samples_of(i):
        bits, zero = widths[i] & 127, widths[i] >> 7
        word = int.from_bytes(raw[start[i]:start[i + 1]], "little")
        n = (1 << bits) - 1 - zero
        step = (hi[i] - lo[i]) / n if n else 0.0
        codes = [word >> bits * s & (1 << bits) - 1 for s in range(512)]
        return [0.0 if zero and c == 0 else f32(lo[i] + (c - zero) * step) for c in codes]

    return print_blocks(raw, 16, tiles, bricks, samples_of)


def print_file(data, fields_allowed):
    """A file, or one within it; returns the name of its grid."""
    chunks = read_container(data)
    meta = json.loads(raw_bytes(chunks[b"META"]))
    print("grid", meta["grid"])
    for row in meta["index_to_world"]:
        print("map", *(f"{v:.17g}" for v in row))
    source = meta["source"]
    print("source", source["file"], source["grid"], source["bytes"], source["xxh3_64"])
    leaves = print_bounds(raw_bytes(chunks[b"BNDS"]))
    if b"micr" in chunks:
        cubes = print_micro(raw_bytes(chunks[b"micr"]), leaves)
    if b"shel" in chunks:
        print_shell(raw_bytes(chunks[b"shel"]))
    if b"DENS" in chunks:
        samples = print_density(raw_bytes(chunks[b"DENS"]))
    if b"DENQ" in chunks:
        samples = print_quantised(raw_bytes(chunks[b"DENQ"]), meta)
    if b"micr" in chunks and (b"DENS" in chunks or b"DENQ" in chunks):
        check_micro(cubes, *samples)
    names = [meta["grid"]]
    for codec, payload, raw in chunks.get(b"fild", []):
        require(fields_allowed and codec == 0 and len(payload) == raw, "a field that cannot be")
        print("field")
        names.append(print_file(payload, False))
    require(len(set(names)) == len(names), "grids of one name")
    return names[0]


def main():
    require(len(sys.argv) == 2, "usage: read_pvol.py FILE.pvol")
    with open(sys.argv[1], "rb") as file:
        print_file(file.read(), True)


main()
