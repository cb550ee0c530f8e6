# SPDX-License-Identifier: Apache-2.0
"""A small EXR reader and writer of our own, so that the tests do not rest on the library under test.

Headers of any file as raw bytes; pixels of uncompressed and ZIP scan-line parts."""
import struct
import zlib

import numpy as np

DTYPES = {0: np.dtype("<u4"), 1: np.dtype("<f2"), 2: np.dtype("<f4")}
ROWS = {0: 1, 2: 1, 3: 16}  # none, zips, zip
IMPLIED = {"channels", "compression", "dataWindow", "displayWindow", "lineOrder", "pixelAspectRatio",
           "screenWindowCenter", "screenWindowWidth", "type", "name", "chunkCount", "tiles"}


def _text(data, at):
    end = data.index(b"\0", at)
    return data[at:end].decode("latin-1"), end + 1


class Part:
    """attrs: {name: (type, bytes)}; channels: {name: 2-D array}"""

    def __init__(self, attrs):
        self.attrs, self.channels = attrs, {}

    @property
    def window(self):
        return struct.unpack("<4i", self.attrs["dataWindow"][1])

    @property
    def extra(self):
        return {k: v for k, v in self.attrs.items() if k not in IMPLIED}

    def channel_list(self):
        data, at, out = self.attrs["channels"][1], 0, []
        while data[at]:
            name, at = _text(data, at)
            kind, linear, xs, ys = struct.unpack_from("<iB3xii", data, at)
            at += 16
            out.append((name, kind, linear, xs, ys))
        return out


def read_headers(data):
    magic, version = struct.unpack_from("<II", data)
    assert magic == 20000630, "not an EXR file"
    at, parts = 8, []
    while data[at]:
        attrs = {}
        while data[at]:
            name, at = _text(data, at)
            kind, at = _text(data, at)
            size, = struct.unpack_from("<i", data, at)
            at += 4
            attrs[name] = (kind, data[at:at + size])
            at += size
        at += 1
        parts.append(Part(attrs))
        if not version & 0x1000:
            return parts, version, at
    return parts, version, at + 1


def _unzip(raw, size):
    data = np.frombuffer(zlib.decompress(raw), np.uint8).astype(np.int64)
    data[1:] -= 128
    data = np.cumsum(data).astype(np.uint8)
    out = np.empty(len(data), np.uint8)
    half = (len(data) + 1) // 2
    out[0::2], out[1::2] = data[:half], data[half:]
    assert len(out) == size
    return out.tobytes()


def _zip(raw):
    data = np.frombuffer(raw, np.uint8)
    data = np.concatenate([data[0::2], data[1::2]]).astype(np.int64)
    data[1:] = data[1:] - data[:-1] + 128
    packed = zlib.compress((data & 255).astype(np.uint8).tobytes())
    return packed if len(packed) < len(raw) else raw


def read(path):
    """Parts with pixels. Scan lines, uncompressed or ZIP(S), not sub-sampled."""
    with open(path, "rb") as file:
        data = file.read()
    parts, version, at = read_headers(data)
    for part in parts:
        x0, y0, x1, y1 = part.window
        height, width = y1 - y0 + 1, x1 - x0 + 1
        rows = ROWS[part.attrs["compression"][1][0]]
        chunks = -(-height // rows)
        table = struct.unpack_from(f"<{chunks}Q", data, at)
        at += 8 * chunks
        planes = {n: np.empty((height, width), DTYPES[k]) for n, k, *_ in part.channel_list()}
        for offset in table:
            offset += 4 if version & 0x1000 else 0
            y, size = struct.unpack_from("<ii", data, offset)
            count = min(rows, y1 - y + 1)
            want = count * sum(p.itemsize * width for p in (q.dtype for q in planes.values()))
            raw = data[offset + 8:offset + 8 + size]
            raw = raw if size == want else _unzip(raw, want)
            pos = 0
            for row in range(y - y0, y - y0 + count):
                for plane in planes.values():
                    n = width * plane.itemsize
                    plane[row] = np.frombuffer(raw, plane.dtype, width, pos)
                    pos += n
        part.channels = planes
    return parts


def _attr(name, kind, value):
    return name.encode("latin-1") + b"\0" + kind.encode("latin-1") + b"\0" + struct.pack("<i", len(value)) + value


def string(text):
    return "string", text.encode("utf-8")


def integer(number):
    return "int", struct.pack("<i", number)


def write(path, parts, *, window=None, display=None, aspect=1.0, compression=3, decreasing=False):
    """parts: [(name or None, {channel: 2-D array}, {attribute: (type, bytes)})]. One part without a name: single."""
    multi = len(parts) > 1
    header, bodies = b"", []
    long_names = any(len(n) > 31 for _, c, a in parts for n in [*c, *a])
    for name, channels, attrs in parts:
        planes = {n: np.ascontiguousarray(channels[n]) for n in sorted(channels, key=lambda s: s.encode())}
        height, width = next(iter(planes.values())).shape
        win = window or (0, 0, width - 1, height - 1)
        kinds = {np.dtype("<u4"): 0, np.dtype("<f2"): 1, np.dtype("<f4"): 2}
        chlist = b"".join(n.encode() + b"\0" + struct.pack("<iB3xii", kinds[p.dtype], 0, 1, 1)
                          for n, p in planes.items()) + b"\0"
        rows = ROWS[compression]
        chunks = -(-height // rows)
        all_attrs = {"channels": ("chlist", chlist), "compression": ("compression", bytes([compression])),
                     "dataWindow": ("box2i", struct.pack("<4i", *win)),
                     "displayWindow": ("box2i", struct.pack("<4i", *(display or win))),
                     "lineOrder": ("lineOrder", bytes([1 if decreasing else 0])),
                     "pixelAspectRatio": ("float", struct.pack("<f", aspect)),
                     "screenWindowCenter": ("v2f", struct.pack("<2f", 0, 0)),
                     "screenWindowWidth": ("float", struct.pack("<f", 1))}
        if multi:
            all_attrs.update(name=string(name), type=string("scanlineimage"), chunkCount=integer(chunks))
        all_attrs.update(attrs)
        header += b"".join(_attr(n, *v) for n, v in all_attrs.items()) + b"\0"
        body = []
        for start in range(0, height, rows):
            raw = b"".join(p[r].tobytes() for r in range(start, min(start + rows, height)) for p in planes.values())
            body.append((start + win[1], raw if compression == 0 else _zip(raw)))
        bodies.append(body)
    head = struct.pack("<II", 20000630, 2 | (0x1000 if multi else 0) | (0x400 if long_names else 0)) + header
    head += b"\0" if multi else b""
    at = len(head) + 8 * sum(len(b) for b in bodies)
    tables, blob = b"", bytearray()
    for index, body in enumerate(bodies):
        offsets = {}
        for y, raw in (reversed(body) if decreasing else body):
            offsets[y] = at + len(blob)
            blob += (struct.pack("<i", index) if multi else b"") + struct.pack("<ii", y, len(raw)) + raw
        tables += b"".join(struct.pack("<Q", offsets[y]) for y, _ in body)
    with open(path, "wb") as file:
        file.write(head + tables + blob)


def bits(plane):
    """For comparing NaN, -0 and all."""
    return plane.view({2: np.uint16, 4: np.uint32}[plane.dtype.itemsize])
