"""Files on disk: written whole or not at all, and never over something that is needed.

A file that is being written lives under a temporary name in the same folder; only when every byte is
on the disk does it take its real name. Whoever looks, at any moment, finds the old file or the new
one and never half of one. A link is followed and stays a link; a pipe or a device is written to as it
stands. What a command reads is protected while it runs (`protected`): no output replaces it.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
import contextlib
import contextvars
import io
import json
import math
import os
from pathlib import Path
import stat
import struct
import sys
import tempfile
import tokenize
from typing import IO, Any
import zipfile
import zlib

import numpy as np

LARGEST = 1e9                                                    # of a number in a model or a data set
LARGEST_FILE = 1 << 31                                           # bytes of one
_protected: contextvars.ContextVar[dict] = contextvars.ContextVar("protected", default={})


class OutputError(ValueError):
    """An output that would replace an input, another output or a checkpoint."""


class FormatError(ValueError):
    """A file that is not of the format asked for; the message names the file, what was found and what was needed."""


@contextlib.contextmanager
def protected(inputs: Iterable[str | Path]) -> Iterator[None]:
    """While the block runs, no `atomic_write` replaces one of these files, under whatever name."""
    token = _protected.set({**_protected.get(), **{identity(path): str(path) for path in inputs}})
    try:
        yield
    finally:
        _protected.reset(token)


def identity(path: str | Path) -> tuple:
    """What two names of one file have in common: device and number of the file, or where it would stand."""
    try:
        found = os.stat(path)
        return (found.st_dev, found.st_ino)
    except OSError:
        return (os.path.realpath(path),)


def check_outputs(outputs: Mapping[str, str | Path], inputs: Mapping[str, str | Path]) -> None:
    """Refuse outputs that are an input or each other, and those that cannot be written.

    outputs, inputs : {the word on the command line: path}.   Raises OutputError, OSError.
    A pipe or a device may be named twice.
    """
    taken = {identity(path): (word, path) for word, path in inputs.items()}
    for word, path in outputs.items():
        check_writable(path)
        if is_special(path):
            continue
        other, where = taken.get(identity(path), (None, None))
        if other is not None:
            raise OutputError(f"{path}: found one file for {word} and {other}"
                              + (f" ({where})" if str(where) != str(path) else "")
                              + ", needed another name for the output; nothing was written")
        taken[identity(path)] = (word, path)


def check_writable(path: str | Path) -> None:
    """Raise OSError now, before hours of work, if a file could not be written there later."""
    target = _target(path)
    if not is_special(path):
        with tempfile.TemporaryFile(dir=target.parent):
            pass


def is_special(path: str | Path) -> bool:
    """Whether something stands there that is no plain file: a pipe, a device, an open descriptor."""
    if _descriptor(path) is not None:
        return True                                              # what the shell opened, even if it is a file
    try:
        return not stat.S_ISREG(os.stat(path).st_mode)
    except OSError:
        return False


def _descriptor(path):
    """The number of the open descriptor that a path like /dev/stdout or a link to it means, or None."""
    step = os.path.abspath(path)
    for _ in range(40):
        if step in ("/dev/stdout", "/dev/stderr"):
            return 1 + (step == "/dev/stderr")
        folder, name = os.path.split(step)
        if folder in ("/dev/fd", "/proc/self/fd", f"/proc/{os.getpid()}/fd") and name.isdigit():
            return int(name)
        if not os.path.islink(step):
            return None
        step = os.path.abspath(os.path.join(folder, os.readlink(step)))
    return None


def _target(path):
    """Where the bytes go: links followed.   Raises OSError for what cannot be written."""
    path = Path(path)
    if path.is_dir():
        raise IsADirectoryError(f"{path} is a folder; name a file to write")
    if is_special(path):
        return path
    target = Path(os.path.realpath(path))
    if target.is_symlink():
        raise FileNotFoundError(f"{path} is a link that leads round in a circle")
    if not target.parent.is_dir():
        raise FileNotFoundError(f"the folder {target.parent} of {path.name} does not exist; make it first")
    if target.exists() and not os.access(target, os.W_OK):
        raise PermissionError(f"{path} may only be read; name another file to write")
    if not os.access(target.parent, os.W_OK | os.X_OK):
        raise PermissionError(f"the folder {target.parent} of {path.name} may not be written to")
    return target


@contextlib.contextmanager
def named(path: str | Path) -> Iterator[None]:
    """An OSError from inside the block says the file's name, not a temporary one or none."""
    try:
        yield
    except OSError as error:
        if error.errno is None or error.strerror is None or str(error.filename) == str(path):
            raise
        raise type(error)(error.errno, error.strerror, str(path)) from None


@contextlib.contextmanager
def atomic_write(path: str | Path, mode: str = "w") -> Iterator[IO]:
    """Open a file for writing that appears under `path` only when the block ends without an error.

    mode : "w" (text, UTF-8, newlines as given) or "wb" (bytes). A link stays and its target is
    written; a pipe or a device gets the bytes as they come.
    Raises OSError when the folder is missing, is not writable or the disk is full, OutputError when
    a command would replace what it reads; `path` is then untouched.
    """
    target = _target(path)
    text: dict[str, Any] = {} if "b" in mode else {"encoding": "utf-8", "newline": ""}
    if is_special(path):
        number = _descriptor(path)
        if number is not None:                                   # at the place where what was printed before ends
            sys.stdout.flush()
        with named(path), open(path if number is None else os.dup(number), mode, **text) as file:
            yield file
        return
    if identity(target) in _protected.get():
        raise OutputError(f"{path}: found an input of this command where an output would stand, needed "
                          "another name for the output; nothing was written there")
    with named(path):
        handle, temporary = tempfile.mkstemp(prefix=f".{target.name[:40]}.", suffix=".part", dir=target.parent)
        try:
            with os.fdopen(handle, mode, **text) as file:
                yield file
                file.flush()
                os.fsync(file.fileno())
            os.chmod(temporary, _permissions(target))
            os.replace(temporary, target)
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


def set_aside(path: str | Path) -> Path | None:
    """Give a file that is there another name, the first free one of PATH.1, PATH.2 ...

    ->  the new name, None where there was no file
    """
    path = Path(path)
    if not os.path.lexists(path):
        return None
    number = 1
    while os.path.lexists(f"{path}.{number}"):
        number += 1
    os.rename(path, f"{path}.{number}")
    return Path(f"{path}.{number}")


def save_npz(path: str | Path, format_name: str, version: int, arrays: Mapping[str, Any],
             facts: Mapping[str, Any]) -> None:
    """Write named arrays and plain facts (numbers, words, lists) as one `.npz` file, whole or not at all.

    The same content gives the same bytes. Nothing in it is pickled, so that reading it can run no code.
    """
    header = json.dumps({"format": format_name, "version": version, "facts": facts}, sort_keys=True)
    archive = io.BytesIO()                                       # a pipe or a device cannot be gone back in
    np.savez(archive, header=np.array(header),
             **{name: np.asarray(array, order="C") for name, array in arrays.items()})
    with atomic_write(path, "wb") as file:
        file.write(archive.getbuffer())


def load_npz(path: str | Path, format_name: str, version: int, needed: Sequence[str],
             facts: Mapping[str, type] | tuple = ()) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
    """Read what `save_npz` wrote, and nothing else.

    needed : names of the arrays that must be there;  facts : {name: type} of the facts that must
    ->  ({name: array}, facts)
    Raises FormatError (foreign, truncated, tampered with, of another format or version, something
    missing) or OSError. Memory grows with the file alone: nothing is unpickled or decompressed.
    """
    kind, data = f"a refimpl {format_name} file", read_bytes(path, LARGEST_FILE)
    try:
        arrays = read_arrays(data)
        header = json.loads(str(arrays.pop("header")))
    except KeyError:
        raise FormatError(f"{path}: found a file without a refimpl header, needed {kind}") from None
    except (ValueError, RecursionError) as error:
        raise FormatError(f"{path}: found something else or a damaged file ({_first_line(error)}), "
                          f"needed {kind}") from None
    if not isinstance(header, dict) or header.get("format") != format_name:
        found = header.get("format") if isinstance(header, dict) else type(header).__name__
        raise FormatError(f"{path}: found a refimpl {str(found)[:40]} file, needed {kind}")
    if header.get("version") != version:
        raise FormatError(f"{path}: found version {str(header.get('version'))[:20]} of the {format_name} "
                          f"format, needed version {version}; was it written by another release? Make it "
                          "again with this one")
    told = header.get("facts")
    missing = [name for name in needed if name not in arrays]
    missing += [name for name, kind_of_fact in dict(facts).items()
                if not isinstance(told, dict) or not _is_fact(told.get(name), kind_of_fact)]
    if missing:
        raise FormatError(f"{path}: found no {', '.join(missing)} of the right kind, needed "
                          f"{', '.join([*needed, *dict(facts)])}")
    return arrays, told


def read_bytes(path: str | Path, most: int) -> bytes:
    """A file's bytes, or a pipe's.   Raises FormatError when there are more than `most`, OSError."""
    data = bytearray()
    with open(path, "rb") as file:
        size = os.fstat(file.fileno()).st_size
        while size <= most and (piece := file.read(1 << 20)):
            data += piece
            size = max(size, len(data))
    if size > most:
        raise FormatError(f"{path}: found more than {most} bytes, needed a file of at most that; is it one?")
    return bytes(data)


def read_arrays(data: bytes, *, names: Iterable[str] | None = None,
                most: int = 0) -> dict[str, np.ndarray]:
    """The arrays of an `.npz` file's bytes, stored without compression.   ->  {name: array}

    names : those that are wanted, where others may be there and are left unread;  most : bytes that a compressed member may have when it is decompressed; with 0 none may be
    compressed. Raises ValueError for anything else, whatever is wrong with it. An array that lies in
    Fortran order comes back in Fortran order.
    """
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            members = archive.infolist()
            if len({info.filename for info in members}) != len(members):
                raise ValueError("a member stands twice in the archive")
            named = {info.filename.removesuffix(".npy"): info for info in members}
            return {name: _read_array(archive, info, most) for name, info in named.items()
                    if names is None or name in names}
    except (ValueError, TypeError, SyntaxError, tokenize.TokenError, EOFError, RecursionError, KeyError,
            IndexError, OverflowError, NotImplementedError, RuntimeError, struct.error,
            zipfile.BadZipFile, zlib.error, MemoryError) as error:
        raise ValueError(_first_line(error)) from None


def plausible(array: np.ndarray) -> bool:
    """Whether all numbers are finite and of a size that motion or trained weights have; NaN is not."""
    return bool((np.abs(array) <= LARGEST).all())


def _is_fact(value, kind):
    """A finite number above 0 for float, else a value of that type; a list holds words."""
    if kind is float:
        return isinstance(value, float) and 0 < value < float("inf")
    return isinstance(value, kind) and (kind is not list or all(isinstance(word, str) for word in value))


def _read_array(archive, info, most):
    """One `.npy` member as long as its own header says, compressed up to `most` bytes.   ->  array"""
    allowed = info.compress_type == zipfile.ZIP_STORED or (
        info.compress_type == zipfile.ZIP_DEFLATED and info.file_size <= most)
    if not allowed or not info.filename.endswith(".npy"):
        raise ValueError(f"member {info.filename[:40]!r} is no plain .npy array")
    with archive.open(info) as member:
        version = np.lib.format.read_magic(member)
        read_header = {(1, 0): np.lib.format.read_array_header_1_0,
                       (2, 0): np.lib.format.read_array_header_2_0}.get(version)
        if read_header is None:
            raise ValueError(f"member {info.filename[:40]!r} has an unknown .npy version")
        shape, fortran, dtype = read_header(member)
        if dtype.kind not in "fiubU" or math.prod(shape) * dtype.itemsize > info.file_size:
            raise ValueError(f"member {info.filename[:40]!r} is no array of numbers, or shorter than it claims")
        data = member.read(info.file_size + 1)                   # bounded, whatever it would expand to; its checksum is verified at the end
    if len(data) != math.prod(shape) * dtype.itemsize:
        raise ValueError(f"member {info.filename[:40]!r} is longer or shorter than it claims")
    return np.frombuffer(data, dtype).reshape(shape, order="F" if fortran else "C").copy(order="K")


def _first_line(error):
    return (str(error).splitlines() or [type(error).__name__])[0][:120]
