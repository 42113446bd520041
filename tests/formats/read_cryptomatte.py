#!/usr/bin/env python3
"""A second reader of Cryptomatte, after the specification of Psyop and without pvol.

read_cryptomatte.py FILE X Y prints what covers the pixel (X, Y), by name and coverage, from most to least.
Names come from the manifest; those whose ids are not the hashes of their names are errors.
"""
import json
import os
import struct
import subprocess
import sys

from read_exr import Reader, read_header

HERE = os.path.dirname(os.path.abspath(__file__))


def murmur3(data):
    mask, h = 0xFFFFFFFF, 0
    rotate = lambda v, n: ((v << n) | (v >> (32 - n))) & mask
    for i in range(0, len(data) - len(data) % 4, 4):
        k = int.from_bytes(data[i:i + 4], "little") * 0xCC9E2D51 & mask
        h = (rotate(h ^ rotate(k, 15) * 0x1B873593 & mask, 13) * 5 + 0xE6546B64) & mask
    tail = data[len(data) - len(data) % 4:]
    if tail:
        k = int.from_bytes(tail, "little") * 0xCC9E2D51 & mask
        h ^= rotate(k, 15) * 0x1B873593 & mask
    h ^= len(data)
    h = (h ^ h >> 16) * 0x85EBCA6B & mask
    h = (h ^ h >> 13) * 0xC2B2AE35 & mask
    return h ^ h >> 16


def to_float(bits):
    if (bits >> 23 & 255) in (0, 255):
        bits ^= 1 << 23
    return struct.unpack("<f", struct.pack("<I", bits))[0]


def metadata(path):
    """Name of the layer, and names by id."""
    with open(path, "rb") as file:
        reader = Reader(file.read())
    reader.take("<II")
    attributes = read_header(reader)
    own = {k: v.decode() for k, v in attributes.items() if k.startswith("cryptomatte/")}
    (key,) = {k.split("/")[1] for k in own}
    of = lambda what: own[f"cryptomatte/{key}/{what}"]
    assert of("hash") == "MurmurHash3_32" and of("conversion") == "uint32_to_float32"
    assert key == f"{murmur3(of('name').encode()):08x}"[:7], "the key is not that of the name"
    names = {}
    for name, bits in json.loads(of("manifest")).items():
        value = struct.unpack("<f", struct.pack("<I", int(bits, 16)))[0]
        assert value == to_float(murmur3(name.encode())), f"{name} has another hash"
        names[value] = name
    return of("name"), names


def main(path, x, y):
    layer, names = metadata(path)
    lines = subprocess.run([sys.executable, os.path.join(HERE, "read_exr.py"), path, x, y],
                           check=True, capture_output=True, text=True).stdout.splitlines()
    values = {}
    for line in lines:
        _, channel, kind, value = line.split()
        if channel.startswith(layer):
            assert kind == "float", "ids must not be rounded"
            values[channel] = float(value)
    for number in range(len(values) // 4):
        for id_of, cover in (("R", "G"), ("B", "A")):
            coverage = values[f"{layer}{number:02}.{cover}"]
            if coverage > 0:
                print(names[values[f"{layer}{number:02}.{id_of}"]], coverage)


if __name__ == "__main__":
    main(*sys.argv[1:])
