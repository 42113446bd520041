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
    require(reader == 1, "needs a newer reader")
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
        chunks[name] = (codec, payload, raw)
        print("chunk", name.decode(), codec, offset, stored, raw)
    require(end == len(data), "bytes after the last chunk")
    return chunks


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


def print_bounds(raw):
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
    for level, cube, bounds in sorted(cubes):
        corner = (box[i] + (v << level + 3) for i, v in enumerate(morton_decode(cube)))
        print("terminal", level, *corner, *(f"{v:.9g}" for v in bounds))


def print_shell(raw):
    kind, count, bound, boxes, depth, _, *ratios = struct.unpack_from("<IIdQiI4f", raw)
    require(len(raw) == 88 + 44 * count, "wrong size of shel")
    numbers = lambda values: [f"{v:.9g}" for v in values]
    print("shell", ("hard", "soft")[kind], f"{bound:.17g}", boxes, depth, *numbers(ratios))
    print("base", *numbers(struct.unpack_from("<10f", raw, 48)))
    for i in range(count):
        print("perturbation", *numbers(struct.unpack_from("<11f", raw, 88 + 44 * i)))


def print_density(raw):
    tiles, bricks = struct.unpack_from("<II", raw)
    require(len(raw) == 8 + 20 * tiles + 2060 * bricks, "wrong size of DENS")
    for i in range(tiles):
        *tile, value = struct.unpack_from("<4if", raw, 8 + 20 * i)
        print("tile", *tile, f"{value:.9g}")
    for i in range(bricks):
        origin = struct.unpack_from("<3i", raw, 8 + 20 * tiles + 12 * i)
        samples = struct.unpack_from("<512f", raw, 8 + 20 * tiles + 12 * bricks + 2048 * i)
        print("brick", *origin, *(f"{v:.9g}" for v in samples))


def main():
    require(len(sys.argv) == 2, "usage: read_pvol.py FILE.pvol")
    with open(sys.argv[1], "rb") as file:
        chunks = read_container(file.read())
    meta = json.loads(raw_bytes(chunks[b"META"]))
    print("grid", meta["grid"])
    for row in meta["index_to_world"]:
        print("map", *(f"{v:.17g}" for v in row))
    source = meta["source"]
    print("source", source["file"], source["grid"], source["bytes"], source["xxh3_64"])
    print_bounds(raw_bytes(chunks[b"BNDS"]))
    if b"shel" in chunks:
        print_shell(raw_bytes(chunks[b"shel"]))
    if b"DENS" in chunks:
        print_density(raw_bytes(chunks[b"DENS"]))


main()
