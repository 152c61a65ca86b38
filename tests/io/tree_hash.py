#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The hash of a tree, computed from nothing but the documents: what is hashed is read from the description of
svo_tree_hash in include/svocl/tree.h, the file format from include/svocl/io.h. It must be what `svocl hash` prints.

XXH3-128 is written here after its specification (xxHash, doc/xxhash_spec.md), for 17 bytes and more.

usage: tree_hash.py PROGRAM SOURCE_DIR; exit code 77 (skipped) without an OpenCL device.
"""
import os
import re
import struct
import subprocess
import sys
import tempfile

# ---- XXH3-128, seed 0 ----

MASK64 = (1 << 64) - 1
P32_1, P32_2, P32_3 = 0x9E3779B1, 0x85EBCA77, 0xC2B2AE3D
P64_1, P64_2, P64_3 = 0x9E3779B185EBCA87, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9
P64_4, P64_5 = 0x85EBCA77C2B2AE63, 0x27D4EB2F165667C5
P_MX1 = 0x165667919E3779F9
SECRET = bytes.fromhex(
    "b8fe6c3923a44bbe7c01812cf721ad1cded46de9839097db7240a4a4b7b3671fcb79e64eccc0e578825ad07dccff7221"
    "b8084674f743248ee03590e6813a264c3c2852bb91c300cb88d0658b1b532ea371644897a20df94e3819ef46a9deacd8"
    "a8fa763fe39c343ff9dcbbc7c70b4f1d8a51e04bcdb45931c89f7ec9d9787364eac5ac8334d3ebc3c581a0fffa1363eb"
    "170ddd51b7f0da49d316552629d4689e2b16be587d47a1fc8ff8b8d17ad031ce45cb3a8f95160428afd7fbcabb4b407e"
)


def word(data, at):
    return int.from_bytes(data[at : at + 8], "little")


def fold(a, b):
    product = a * b
    return (product & MASK64) ^ (product >> 64)


def avalanche(h):
    h ^= h >> 37
    h = h * P_MX1 & MASK64
    return h ^ h >> 32


def mix16(data, at, secret_at):
    return fold(word(data, at) ^ word(SECRET, secret_at), word(data, at + 8) ^ word(SECRET, secret_at + 8))


def mix32(low, high, data, at, other_at, secret_at):
    low = (low + mix16(data, at, secret_at) & MASK64) ^ (word(data, other_at) + word(data, other_at + 8) & MASK64)
    high = (high + mix16(data, other_at, secret_at + 16) & MASK64) ^ (word(data, at) + word(data, at + 8) & MASK64)
    return low, high


def finish_short(low, high, length):
    sum_low = low + high & MASK64
    sum_high = low * P64_1 + high * P64_4 + length * P64_2 & MASK64
    return avalanche(sum_low), -avalanche(sum_high) & MASK64


def hash_17_to_128(data):
    length = len(data)
    low, high = length * P64_1 & MASK64, 0
    for k in range((length - 1) // 32, -1, -1):
        low, high = mix32(low, high, data, 16 * k, length - 16 * (k + 1), 32 * k)
    return finish_short(low, high, length)


def hash_129_to_240(data):
    length = len(data)
    low, high = length * P64_1 & MASK64, 0
    for k in range(4):
        low, high = mix32(low, high, data, 32 * k, 32 * k + 16, 32 * k)
    low, high = avalanche(low), avalanche(high)
    for k in range(4, length // 32):
        low, high = mix32(low, high, data, 32 * k, 32 * k + 16, 3 + 32 * (k - 4))
    low, high = mix32(low, high, data, length - 16, length - 32, 136 - 17 - 16)
    return finish_short(low, high, length)


def accumulate(lanes, stripe, secret_at):
    words = struct.unpack("<8Q", stripe)
    keys = struct.unpack_from("<8Q", SECRET, secret_at)
    for i in range(8):
        value = words[i] ^ keys[i]
        lanes[i ^ 1] = lanes[i ^ 1] + words[i] & MASK64
        lanes[i] = lanes[i] + (value & 0xFFFFFFFF) * (value >> 32) & MASK64


def merge(lanes, secret_at, start):
    total = start
    for i in range(4):
        total += fold(
            lanes[2 * i] ^ word(SECRET, secret_at + 16 * i), lanes[2 * i + 1] ^ word(SECRET, secret_at + 16 * i + 8)
        )
    return avalanche(total & MASK64)


def hash_long(data):
    length = len(data)
    lanes = [P32_3, P64_1, P64_2, P64_3, P64_4, P32_2, P64_5, P32_1]
    scramble_keys = struct.unpack_from("<8Q", SECRET, 192 - 64)
    for stripe in range((length - 1) // 64):
        accumulate(lanes, data[64 * stripe : 64 * stripe + 64], stripe % 16 * 8)
        if stripe % 16 == 15 and 64 * (stripe + 1) <= (length - 1) // 1024 * 1024:
            lanes = [((lane ^ lane >> 47) ^ key) * P32_1 & MASK64 for lane, key in zip(lanes, scramble_keys)]
    accumulate(lanes, data[length - 64 :], 192 - 64 - 7)
    return (merge(lanes, 11, length * P64_1 & MASK64), merge(lanes, 192 - 64 - 11, ~(length * P64_2) & MASK64))


def xxh3_128(data):
    """32 hexadecimal digits, the high half first."""
    length = len(data)
    if length < 17:
        raise ValueError("%d bytes are too few" % length)
    low, high = (hash_17_to_128 if length <= 128 else hash_129_to_240 if length <= 240 else hash_long)(data)
    return "%016x%016x" % (high, low)


# ---- the documents ----

FORMATS = {"u8": "B", "u16": "H", "i16": "h", "u32": "I", "u64": "Q", "f64": "d"}


def read(path):
    with open(path, encoding="utf-8") as file:
        return file.read()


def table_of_fields(text):
    """Lines "offset bytes type name" and "offset bytes type name[count]": {name: (offset, struct format)}."""
    fields = {}
    for offset, size, kind, name, count in re.findall(
        r"^ \*     (\d+) +(\d+) +(u16|u32|u64|f64) (\w+)(?:\[(\d+)\])?", text, re.MULTILINE
    ):
        layout = "<%d%s" % (int(count or 1), FORMATS[kind])
        if struct.calcsize(layout) != int(size):
            raise ValueError("%s: %s bytes are documented, its type has %d" % (name, size, struct.calcsize(layout)))
        fields[name] = (int(offset), layout)
    return fields


class Documents:
    def __init__(self, source):
        tree_h, io_h = (read(os.path.join(source, "include/svocl", name)) for name in ("tree.h", "io.h"))
        trees = io_h[: io_h.index("Files of compact trees")]
        head, entry = trees.split("chunk entry\n")
        self.header = table_of_fields(head)
        self.entry = table_of_fields(entry)
        # svo_tree_buffer's values are those of the chunks' kinds.
        values = tree_h[tree_h.index("typedef enum svo_tree_buffer") : tree_h.index("SVO_TREE_BUFFER_COUNT")]
        self.kinds = re.findall(r'/\*\*< "(\w+)" \*/', values)
        self.bits = dict(
            (name, int(bit)) for bit, name in re.findall(r"bit (\d) (\w+)", re.search(r"u16 need: (.*)", io_h).group(1))
        )
        described = tree_h[tree_h.index("/** Hashes a tree") : tree_h.index("svo_tree_hash(const svo_tree")]
        nodes, rest = described.split("and with SVO_HASH_ALL also")
        self.node_lines, self.other_lines = (
            re.findall(r"^ \*     (.*)$", part, re.MULTILINE) for part in (nodes, rest)
        )
        if len(self.node_lines) < 5 or len(self.other_lines) != 7:
            raise ValueError(
                "the description of svo_tree_hash lists %d and %d lines" % (len(self.node_lines), len(self.other_lines))
            )


# ---- files ----


class TreeFile:
    """A .svo file whose chunks are not compressed: arrays level by level."""

    def __init__(self, documents, path):
        with open(path, "rb") as file:
            self.data = file.read()
        self.fields = {
            name: struct.unpack_from(layout, self.data, offset) for name, (offset, layout) in documents.header.items()
        }
        self.chunks = {}
        for index in range(self["chunk_count"]):
            at = self.first_entry(documents) + 40 * index
            entry = {
                name: struct.unpack_from(layout, self.data, at + offset)[0]
                for name, (offset, layout) in documents.entry.items()
            }
            if entry["codec"] != 0:
                raise ValueError("%s: a compressed chunk" % path)
            begin = entry["offset"]
            name = documents.kinds[entry["kind"]]
            self.chunks[name] = self.chunks.get(name, b"") + self.data[begin : begin + entry["plain_bytes"]]
        self.chunks["first_child"] = self.first_children()

    def first_children(self):
        """A node's children begin where those of the node before it end, from node 1 on."""
        numbers, following = [], 1
        for mask in self.chunks["child_mask"]:
            numbers.append(following)
            following += bin(mask).count("1")
        return struct.pack("<%dI" % len(numbers), *numbers)

    def first_entry(self, documents):
        offset, layout = documents.header["level_begin"]
        return offset + struct.calcsize(layout)

    def __getitem__(self, name):
        return self.fields[name][0]

    def payload_count(self):
        begin = self.fields["level_begin"]
        return begin[self["depth"] + 1] - begin[self["payload_level"]]


PAYLOAD = {"colors": "color", "normals": "normal", "materials": "material", "fills": "fill"}


def array_bytes(documents, tree, name, element_bytes):
    """The length, then the elements; constant payload is repeated for every node that has payload."""
    held = tree.chunks.get(name, b"")
    if name in PAYLOAD and tree["constant"] >> documents.bits[PAYLOAD[name]] & 1:
        if len(held) != element_bytes:
            raise ValueError("constant %s have %d bytes" % (name, len(held)))
        held = held * tree.payload_count()
    if len(held) % element_bytes != 0:
        raise ValueError("%s have %d bytes, elements of %d" % (name, len(held), element_bytes))
    return struct.pack("<Q", len(held)) + held


def line_bytes(documents, tree, line):
    """The bytes that a line of the description stands for."""
    array = re.fullmatch(r"array (\w+): (?:(\d) )?(\w+) each(, if the tree holds it)?", line)
    if array:
        name, count, kind, if_held = array.groups()
        if if_held and name not in tree.chunks:
            return b""
        return array_bytes(documents, tree, name, int(count or 1) * struct.calcsize(FORMATS[kind]))
    levels = re.fullmatch(r"u32 (\w+)\[0\] \.\. \1\[depth \+ 1\]", line)
    if levels:
        return b"".join(struct.pack("<I", value) for value in tree.fields[levels.group(1)][: tree["depth"] + 2])
    total = b""
    for item in line.split(", "):
        kind, name, count = re.fullmatch(r"(u32|f64) (\w+)(?:\[(\d)\])?", item).groups()
        values = [int(name)] if name.isdigit() else tree.fields[name][: int(count or 1)]
        total += struct.pack("<%d%s" % (len(values), FORMATS[kind]), *values)
    return total


def hashes(documents, path):
    """Of all and of the nodes, and how many bytes were hashed."""
    tree = TreeFile(documents, path)
    nodes = b"".join(line_bytes(documents, tree, line) for line in documents.node_lines)
    everything = nodes + b"".join(line_bytes(documents, tree, line) for line in documents.other_lines)
    return (xxh3_128(everything), xxh3_128(nodes)), (len(everything), len(nodes))


# ---- trees that differ in every way the description mentions ----

ALL = "color,normal,rays,material,fill,projected-area"
CASES = (
    "scene:cube -d 1 --need none",  # the three ways in which XXH3-128 treats lengths: 17 to 128 bytes,
    "scene:cube -d 2 --need none",  # 129 to 240,
    "scene:cube -d 4 --need none",  # and more
    "scene:cube -d 3",
    "scene:cube -d 3 --need " + ALL,  # constant color and material
    "scene:cornell:300 -d 4 --need color,normal,rays,material,fill",
    "scene:knot:300 -d 4 --weights center --need projected-area",
    "scene:cornell:300 -d 4 --need " + ALL,  # payload that differs
    "scene:cornell:300 -d 4 --payload-level 3 --need " + ALL,
    "scene:cube -d 4 --payload-level 4 --need " + ALL,
    "scene:knot:300 -d 4 --coverage closed",
    "scene:dust:20 -d 13 --need rays",
    "scene:knot:300 -d 4 --origin=-3,-3,-3 --edge 7 --need normal",
)


def run(program, *arguments):
    done = subprocess.run([program, *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE, check=False)
    return done.returncode, done.stdout.decode(), done.stderr.decode()


def main(program, source):
    documents = Documents(source)
    failed, ways = 0, set()
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "tree.svo")
        for case in CASES:
            code, _, errors = run(program, "build", *case.split(), "-o", path)
            if code != 0 and "no OpenCL" in errors:
                print("skipped: " + errors.strip())
                return 77
            if code != 0:
                print("%s: %s" % (case, errors))
                return 1
            ours, lengths = hashes(documents, path)
            theirs = tuple(run(program, "hash", path, *option)[1].strip() for option in ((), ("--nodes",)))
            print("%s %s: %d and %d bytes" % ("ok    " if ours == theirs else "FAILED", case, *lengths))
            ways.update((length > 128) + (length > 240) for length in lengths)
            if ours != theirs:
                print("  from the text %s, %s; svocl hash %s, %s" % (ours + theirs))
                failed += 1
    if ways != {0, 1, 2}:
        print("FAILED: the cases do not cover all ways of XXH3-128: %s" % sorted(ways))
        failed += 1
    return 1 if failed else 0


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit("usage: tree_hash.py PROGRAM SOURCE_DIR")
    sys.exit(main(sys.argv[1], sys.argv[2]))
