"""glTF as GLB: what the one target found is a start for the other, which has the same reader behind its container.

usage: glb.py TO FILE|FOLDER...    writes two to TO for each input of target gltf: as it is, and the first buffer in the BIN chunk"""
import base64
import binascii
import hashlib
import os
import re
import struct
import sys

# data.bin of fuzz_files.c: a square's four corners and six indices of 16 bits.
SQUARE = struct.pack("<12f6H", 0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 0, 1, 2, 0, 2, 3)
URI = re.compile(rb'"uri"\s*:\s*"([^"]*)"\s*,?')


def bytes_of(uri):
    head, comma, text = uri.partition(b",")
    if not comma or b"base64" not in head:
        return SQUARE
    try:
        return base64.b64decode(text + b"=" * (-len(text) % 4))
    except binascii.Error:
        return SQUARE


def without_uri(text):
    """The text, and the bytes that its first buffer named. Broken texts are cut all the same: nothing is parsed."""
    uri = URI.search(text)
    if not uri:
        return text, SQUARE
    before, after = text[:uri.start()], text[uri.end():]
    if after.lstrip().startswith(b"}"):
        before = before.rstrip().removesuffix(b",")
    return before + after, bytes_of(uri[1])


def glb(text, data):
    text += b" " * (-len(text) % 4)
    data += b"\0" * (-len(data) % 4)
    return (b"glTF" + struct.pack("<II", 2, 28 + len(text) + len(data)) + struct.pack("<I4s", len(text), b"JSON") + text
            + struct.pack("<I4s", len(data), b"BIN\0") + data)


def main(to, sources):
    os.makedirs(to, exist_ok=True)
    for source in sources:
        names = [os.path.join(source, name) for name in os.listdir(source)] if os.path.isdir(source) else [source]
        for name in names:
            with open(name, "rb") as file:
                text = file.read()
            for content in (glb(text, b""), glb(*without_uri(text))):
                with open(os.path.join(to, hashlib.sha1(content).hexdigest()), "wb") as file:
                    file.write(content)


main(sys.argv[1], sys.argv[2:])
