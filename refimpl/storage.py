"""Files on disk: written whole or not at all.

A file that is being written lives under a temporary name in the same folder; only when every byte is on the disk does it
take its real name. Whoever looks, at any moment, finds the old file or the new one and never half of one.
"""

import contextlib
import io
import json
import math
import os
from pathlib import Path
import struct
import tempfile
import tokenize
import zipfile
import zlib

import numpy as np


@contextlib.contextmanager
def atomic_write(path, mode="w"):
    """Open a file for writing that appears under `path` only when the block ends without an error.

    mode : "w" (text, UTF-8, newlines as given) or "wb" (bytes).
    Raises OSError when the folder is missing, is not writable or the disk is full; `path` is then untouched.
    """
    path = Path(path)
    if path.is_dir():
        raise IsADirectoryError(f"{path} is a folder; name a file to write")
    if not path.parent.is_dir():
        raise FileNotFoundError(f"the folder {path.parent} of {path.name} does not exist; make it first")
    text = {} if "b" in mode else {"encoding": "utf-8", "newline": ""}
    handle, temporary = tempfile.mkstemp(prefix=f".{path.name[:40]}.", suffix=".part", dir=path.parent)
    try:
        with os.fdopen(handle, mode, **text) as file:
            yield file
            file.flush()
            os.fsync(file.fileno())
        os.chmod(temporary, _permissions(path))
        os.replace(temporary, path)
    except BaseException:
        with contextlib.suppress(OSError):
            os.unlink(temporary)
        raise


def _permissions(path):
    """The mode a plain open() would have given: that of the file being replaced, or the process's default."""
    if path.exists():
        return path.stat().st_mode & 0o7777
    mask = os.umask(0)
    os.umask(mask)
    return 0o666 & ~mask


class FormatError(ValueError):
    """A file that is not of the format asked for; the message names the file, what was found and what was needed."""


def save_npz(path, format_name, version, arrays, facts):
    """Write named arrays and a dict of plain facts (numbers, words, lists) as one `.npz` file, whole or not at all.

    The same content gives the same bytes. Nothing in it is pickled, so that reading it can run no code.
    """
    header = json.dumps({"format": format_name, "version": version, "facts": facts}, sort_keys=True)
    with atomic_write(path, "wb") as file:
        np.savez(file, header=np.array(header), **{name: np.asarray(array, order="C") for name, array in arrays.items()})


def load_npz(path, format_name, version, needed, facts=()):
    """Read what `save_npz` wrote, and nothing else.

    needed : names of the arrays that must be there;  facts : {name: type} of the facts that must   ->  ({name: array}, facts)
    Raises FormatError (foreign, truncated, tampered with, of another format or a newer version, something missing) or OSError.
    Memory grows with the file alone: nothing is unpickled or decompressed, and an array that claims to be larger than its bytes is refused.
    """
    kind = f"a refimpl {format_name} file"
    data = io.BytesIO(Path(path).read_bytes())                   # an OSError of the disk is its own; what follows is about the content
    try:
        with zipfile.ZipFile(data) as archive:
            arrays = {info.filename.removesuffix(".npy"): _read_array(archive, info) for info in archive.infolist()}
        header = json.loads(str(arrays.pop("header")))
    except KeyError:
        raise FormatError(f"{path}: found a file without a refimpl header, needed {kind}") from None
    except (ValueError, TypeError, SyntaxError, tokenize.TokenError, EOFError, RecursionError, OverflowError, NotImplementedError, RuntimeError, struct.error, zipfile.BadZipFile,
            zlib.error, MemoryError) as error:
        raise FormatError(f"{path}: found something else or a damaged file ({_first_line(error)}), needed {kind}") from None
    if not isinstance(header, dict) or header.get("format") != format_name:
        found = header.get("format") if isinstance(header, dict) else type(header).__name__
        raise FormatError(f"{path}: found a refimpl {str(found)[:40]} file, needed {kind}")
    if header.get("version") != version:
        raise FormatError(f"{path}: found version {str(header.get('version'))[:20]} of the {format_name} format, needed version {version}; "
                          "was it written by another release? Make it again with this one")
    told = header.get("facts")
    missing = [name for name in needed if name not in arrays]
    missing += [name for name, kind_of_fact in dict(facts).items() if not isinstance(told, dict) or not _is_fact(told.get(name), kind_of_fact)]
    if missing:
        raise FormatError(f"{path}: found no {', '.join(missing)} of the right kind, needed {', '.join([*needed, *dict(facts)])}")
    return arrays, told


def _is_fact(value, kind):
    """A finite number above 0 for float, else a value of that type; a list holds words."""
    if kind is float:
        return isinstance(value, float) and 0 < value < float("inf")
    return isinstance(value, kind) and (kind is not list or all(isinstance(word, str) for word in value))


def _read_array(archive, info):
    """One `.npy` member, stored without compression, as long as its own header says.   ->  array"""
    if info.compress_type != zipfile.ZIP_STORED or not info.filename.endswith(".npy"):
        raise ValueError(f"member {info.filename[:40]!r} is no plain .npy array")
    with archive.open(info) as member:
        version = np.lib.format.read_magic(member)
        read_header = {(1, 0): np.lib.format.read_array_header_1_0, (2, 0): np.lib.format.read_array_header_2_0}.get(version)
        if read_header is None:
            raise ValueError(f"member {info.filename[:40]!r} has an unknown .npy version")
        shape, fortran, dtype = read_header(member)
        if dtype.kind not in "fiubU" or math.prod(shape) * dtype.itemsize > info.file_size:
            raise ValueError(f"member {info.filename[:40]!r} is no array of numbers, or shorter than it claims")
        data = member.read()                                     # the zip's checksum is verified at its end
    if len(data) != math.prod(shape) * dtype.itemsize:
        raise ValueError(f"member {info.filename[:40]!r} is longer or shorter than it claims")
    return np.frombuffer(data, dtype).reshape(shape, order="F" if fortran else "C").copy()


def _first_line(error):
    return (str(error).splitlines() or [type(error).__name__])[0][:120]


def check_writable(path):
    """Raise OSError now, before hours of work, if a file could not be written there later."""
    path = Path(path)
    if path.is_dir():
        raise IsADirectoryError(f"{path} is a folder; name a file to write")
    if not path.parent.is_dir():
        raise FileNotFoundError(f"the folder {path.parent} of {path.name} does not exist; make it first")
    with tempfile.TemporaryFile(dir=path.parent):
        pass
