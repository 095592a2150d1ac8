"""Writes TIFF files with tifffile and says what tifffile reads of them.

A request is a line of JSON, {"path", "type", "shape", "bytes", "options"}, with the values after it; the options are imwrite's. A
request without "bytes" is a file to read. The answer is a line of JSON, {"shape"}, and the values as 64-bit floats.
"""

import json
import sys

import numpy as np
import tifffile

TYPES = {"u8": "u1", "i8": "i1", "u16": "u2", "i16": "i2", "u32": "u4", "i32": "i4", "f16": "f2", "f32": "f4", "f64": "f8", "i64": "i8", "u64": "u8"}


def main():
    while line := sys.stdin.buffer.readline():
        request = json.loads(line)
        if "bytes" in request:
            values = np.frombuffer(sys.stdin.buffer.read(request["bytes"]), "<" + TYPES[request["type"]])
            options = {key: tuple(v) if isinstance(v, list) else v for key, v in request["options"].items()}
            if options.get("photometric") == "palette":
                options["colormap"] = np.tile(np.arange(256, dtype="u2") * 257, (3, 1))
            tifffile.imwrite(request["path"], values.reshape(request["shape"]), **options)
        read = tifffile.imread(request["path"])
        sys.stdout.buffer.write(json.dumps({"shape": read.shape}).encode() + b"\n")
        sys.stdout.buffer.write(np.ascontiguousarray(read.astype("<f8")).tobytes())
        sys.stdout.buffer.flush()


main()
