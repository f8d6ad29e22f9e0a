"""Reads what Fathom writes as .exr: scan lines of 32-bit numbers, by zip or as they are."""
import struct
import zlib


def text(data, at):
    end = data.index(b"\0", at)
    return data[at:end].decode(), end + 1


def header(data):
    """Its attributes, by name, and where the table of the blocks begins."""
    at, found = 8, {}
    while data[at]:
        name, at = text(data, at)
        kind, at = text(data, at)
        size, = struct.unpack_from("<i", data, at)
        found[name] = data[at + 4:at + 4 + size]
        at += 4 + size
    return found, at + 1


def channels(of):
    """Names in the order of the file; none may be a half."""
    at, names = 0, []
    while of[at]:
        name, at = text(of, at)
        if struct.unpack_from("<i", of, at)[0] == 1:
            raise ValueError(f"{name}: expected numbers of 32 bits, which --exr-float writes")
        names.append(name)
        at += 16
    return names


def unzipped(data, size):
    """Differences of bytes, of which the even ones come first."""
    if len(data) == size:
        return data
    packed, plain, last = zlib.decompress(data), bytearray(size), 128
    half = (size + 1) // 2
    for k, byte in enumerate(packed):
        last = (last + byte - 128) & 255
        plain[2 * k if k < half else 2 * (k - half) + 1] = last
    return bytes(plain)


def read(path):
    """(x0, y0, width, height) and for each row the bytes of each channel, by name."""
    with open(path, "rb") as file:
        data = file.read()
    about, at = header(data)
    x0, y0, x1, y1 = struct.unpack("<4i", about["dataWindow"])
    names, width, rows = channels(about["channels"]), x1 - x0 + 1, {}
    lines = {0: 1, 2: 1, 3: 16}[about["compression"][0]]
    for k in range((y1 - y0) // lines + 1):
        block, = struct.unpack_from("<Q", data, at + 8 * k)
        y, size = struct.unpack_from("<ii", data, block)
        count = min(lines, y1 + 1 - y)
        plain = unzipped(data[block + 8:block + 8 + size], count * width * len(names) * 4)
        for line in range(count):
            for c, name in enumerate(names):
                begin = (line * len(names) + c) * width * 4
                rows.setdefault(y + line, {})[name] = plain[begin:begin + width * 4]
    return (x0, y0, width, y1 - y0 + 1), rows
