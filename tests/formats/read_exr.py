#!/usr/bin/env python3
"""A second reader of EXR files, after the format's published layout and without OpenEXR.

read_exr.py FILE X Y prints each channel of the pixel (X, Y): the part's number, the channel's name, its
type and its value. It reads scanlines in one part or several, not compressed or by zips and zip.
"""
import struct
import sys
import zlib

TYPES = {0: ("uint", "<I"), 1: ("half", "<e"), 2: ("float", "<f")}
ROWS = {0: 1, 2: 1, 3: 16}  # of a block: none, zips, zip


class Reader:
    def __init__(self, data):
        self.data, self.at = data, 0

    def take(self, layout):
        values = struct.unpack_from(layout, self.data, self.at)
        self.at += struct.calcsize(layout)
        return values if len(values) > 1 else values[0]

    def name(self):
        end = self.data.index(b"\0", self.at)
        text = self.data[self.at:end].decode()
        self.at = end + 1
        return text


def read_header(reader):
    """Attributes by name, as bytes; none where there are no more parts."""
    attributes = {}
    while name := reader.name():
        reader.name()  # its type
        size = reader.take("<i")
        attributes[name] = reader.data[reader.at:reader.at + size]
        reader.at += size
    return attributes


def read_channels(header):
    """Names and types in their order in the file, which is that of the alphabet."""
    reader, channels = Reader(header["channels"]), []
    while name := reader.name():
        kind, _, x, y = reader.take("<iiii")
        assert (x, y) == (1, 1), "subsampled"
        channels.append((name, kind))
    return channels


def unpack(block, size):
    """Zip stores differences of bytes, the even ones before the odd ones."""
    if len(block) == size:
        return block
    mixed = bytearray(zlib.decompress(block))
    for i in range(1, len(mixed)):
        mixed[i] = (mixed[i - 1] + mixed[i] - 128) & 255
    half = (len(mixed) + 1) // 2
    plain = bytearray(len(mixed))
    plain[0::2], plain[1::2] = mixed[:half], mixed[half:]
    return bytes(plain)


def read_pixel(data, header, table, several, x, y):
    left, top, right, bottom = struct.unpack("<iiii", header["dataWindow"])
    rows, channels = ROWS[header["compression"][0]], read_channels(header)
    width, first = right - left + 1, (y - top) // rows * rows
    reader = Reader(data)
    reader.at = table[first // rows] + (4 if several else 0)
    start, size = reader.take("<ii")
    assert start == top + first, "a block of other rows"
    row_bytes = sum(struct.calcsize(TYPES[kind][1]) for _, kind in channels) * width
    count = min(rows, bottom - start + 1)
    block = unpack(data[reader.at:reader.at + size], count * row_bytes)
    assert len(block) == count * row_bytes, "a block of another size"
    at = (y - start) * row_bytes
    for name, kind in channels:
        label, layout = TYPES[kind]
        bytes_each = struct.calcsize(layout)
        yield name, label, struct.unpack_from(layout, block, at + (x - left) * bytes_each)[0]
        at += width * bytes_each


def main(file, x, y):
    data = open(file, "rb").read()
    reader = Reader(data)
    magic, version = reader.take("<iI")
    assert magic == 20000630 and version & 0xff == 2, "not EXR"
    several = bool(version & 0x1000)
    headers = [read_header(reader)]
    while several and (header := read_header(reader)):
        headers.append(header)
    tables = []
    for header in headers:
        top, bottom = struct.unpack("<4xi4xi", header["dataWindow"])
        rows = ROWS[header["compression"][0]]
        blocks = (bottom - top + rows) // rows
        tables.append(struct.unpack_from(f"<{blocks}Q", data, reader.at))
        reader.at += 8 * blocks
    for i, (header, table) in enumerate(zip(headers, tables)):
        for name, label, value in read_pixel(data, header, table, several, x, y):
            print(i, name, label, value)


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]), int(sys.argv[3]))
