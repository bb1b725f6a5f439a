"""Files on disk: written whole or not at all, and never over something that is needed.

A file lives under a temporary name in the same folder until every byte is on the disk. Whoever
looks, at any moment, finds the old file or the new one and never half of one. A link is followed
and stays a link; a pipe or a device gets the bytes as they come. While a command runs, no output
replaces what it reads (`protected`).
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
import contextlib
import contextvars
import io
import json
import math
import os
from pathlib import Path
import secrets
import stat
import sys
import tempfile
from typing import IO, Any
import zipfile

import numpy as np

LARGEST = 1e9                                                # of a number in a model or a data set
LARGEST_FILE = 1 << 31                                       # bytes of one
_protected: contextvars.ContextVar[dict] = contextvars.ContextVar("protected", default={})


class OutputError(ValueError):
    """An output that would replace an input, another output or a checkpoint."""


class FormatError(ValueError):
    """A file of another format than the one asked for."""


@contextlib.contextmanager
def protected(inputs: Iterable[str | Path]) -> Iterator[list[str]]:
    """While the block runs, no `atomic_write` replaces one of these files, under whatever name.

    ->  yields all that are protected then
    """
    token = _protected.set({**_protected.get(), **{identity(path): str(path) for path in inputs}})
    try:
        yield list(_protected.get().values())
    finally:
        _protected.reset(token)


def identity(path: str | Path) -> tuple:
    """What all names of one file share: its device and number, or the place where it would be."""
    try:
        found = os.stat(path)
        return (found.st_dev, found.st_ino)
    except OSError:
        return (os.path.realpath(path),)


def check_outputs(outputs: Mapping[str, str | Path], inputs: Mapping[str, str | Path]) -> None:
    """Refuse outputs that are an input or each other, and those that cannot be written.

    outputs, inputs : {the word on the command line: path}
    A pipe or a device may be named twice.   Raises OutputError, OSError."""
    taken = {identity(path): (word, path) for word, path in inputs.items()}
    for word, path in outputs.items():
        check_writable(path)
        if is_special(path):
            continue
        if identity(path) in taken:
            other, where = taken[identity(path)]
            raise OutputError(f"{path}: found one file for {word} and {other}"
                              + (f" ({where})" if str(where) != str(path) else "")
                              + ", needed another name for the output; nothing was written")
        taken[identity(path)] = (word, path)


def check_writable(path: str | Path) -> None:
    """Raise OSError now, before hours of work, if a file could not be written there later."""
    target = _target(path)
    if not is_special(path):
        with _named(path), tempfile.TemporaryFile(dir=target.parent):
            return


def check_folder(path: str | Path) -> None:
    """The same for a folder, which may be made later."""
    whole = Path(os.path.abspath(path))
    with _named(path), tempfile.TemporaryFile(dir=next(
            there for there in (whole, *whole.parents) if os.path.lexists(there))):
        pass


def is_special(path: str | Path) -> bool:
    """Whether no plain file stands there but a pipe, a device, or what the shell has opened."""
    try:
        return _descriptor(path) is not None or not stat.S_ISREG(os.stat(path).st_mode)
    except OSError:
        return False


def _descriptor(path):
    """The number of the open descriptor that a path like /dev/stdout, or a link to it, means."""
    step = os.path.abspath(path)
    for _ in range(40):                                      # links one after another, as in Linux
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
    folder = f"the folder {target.parent} of {path.name}"
    if target.is_symlink():
        raise FileNotFoundError(f"{path} is a link that leads round in a circle")
    if not target.parent.is_dir():
        raise FileNotFoundError(f"{folder} does not exist; make it first")
    if target.exists() and not (os.access(target, os.W_OK) and target.stat().st_mode & 0o222):
        raise PermissionError(f"{path} may only be read; name another file to write")
    if not os.access(target.parent, os.W_OK | os.X_OK):
        raise PermissionError(f"{folder} may not be written to")
    return target


@contextlib.contextmanager
def _named(path):
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

    mode : "w" (text, UTF-8, newlines as given) or "wb" (bytes)
    Raises OSError, OutputError (a command would replace what it reads); `path` is then untouched.
    """
    target = _target(path)
    text: dict[str, Any] = {} if "b" in mode else {"encoding": "utf-8", "newline": ""}
    if is_special(path):
        number = _descriptor(path)
        if number is not None:                               # what was printed before comes first
            sys.stdout.flush()
        with _named(path), open(path if number is None else os.dup(number), mode, **text) as file:
            yield file
        return
    if identity(target) in _protected.get():
        raise OutputError(f"{path}: found an input of this command where an output would stand, "
                          "needed another name for the output; nothing was written there")
    with _named(path):
        # its name is known before it is there, so that a signal at any moment leaves none behind
        temporary = target.parent / f".{target.name[:40]}.{secrets.token_hex(8)}.part"
        try:
            with open(temporary, mode.replace("w", "x"), **text) as file:
                yield file
                file.flush()
                os.fsync(file.fileno())
            if target.exists():
                os.chmod(temporary, stat.S_IMODE(target.stat().st_mode))
            os.replace(temporary, target)
        except BaseException:
            with contextlib.suppress(OSError):
                os.unlink(temporary)
            raise
    with contextlib.suppress(OSError), contextlib.ExitStack() as stack:  # not all folders can be
        stack.callback(os.close, handle := os.open(target.parent, os.O_RDONLY))
        os.fsync(handle)


def save_npz(path: str | Path, format_name: str, version: int, arrays: Mapping[str, Any],
             facts: Mapping[str, Any]) -> None:
    """Write named arrays and plain facts (numbers, words, lists) as one `.npz` file.

    The same content gives the same bytes. Nothing is pickled, so that reading can run no code.

    >>> with tempfile.TemporaryDirectory() as folder:
    ...     save_npz(f"{folder}/walk", "walk", 1, {"feet": [0.0, 1.0]}, {"leg": 80.0})
    ...     load_npz(f"{folder}/walk", "walk", 1, ["feet"], {"leg": float})
    ({'feet': array([0., 1.])}, {'leg': 80.0})
    """
    header = json.dumps({"format": format_name, "version": version, "facts": facts}, sort_keys=True)
    members: Any = {name: np.asarray(array, order="C") for name, array in arrays.items()}
    with atomic_write(path, "wb") as file:
        archive = io.BytesIO() if is_special(path) else file     # a pipe cannot be gone back in
        np.savez(archive, header=np.array(header), **members)
        if isinstance(archive, io.BytesIO):
            file.write(archive.getbuffer())


def load_npz(path: str | Path, format_name: str, version: int, needed: Sequence[str],
             facts: Mapping[str, type] | tuple = ()) -> tuple[dict[str, np.ndarray], dict]:
    """Read what `save_npz` wrote, and nothing else: nothing is unpickled or decompressed.

    needed : names of the arrays that must be there
    facts : {name: type} of the facts that must be there
    ->  ({name: array}, facts).   Raises FormatError (foreign, damaged or another version), OSError.
    """
    kind, data = f"a refimpl {format_name} file", read_bytes(path, LARGEST_FILE)
    try:
        arrays = read_arrays(data)
        header = json.loads(str(arrays.pop("header")))
    except KeyError:
        raise FormatError(f"{path}: found a file without a refimpl header, needed {kind}") from None
    except (ValueError, RecursionError) as error:
        raise FormatError(f"{path}: found something else or a damaged file ({error}), "
                          f"needed {kind}") from None
    if not isinstance(header, dict) or header.get("format") != format_name:
        found = header.get("format") if isinstance(header, dict) else type(header).__name__
        raise FormatError(f"{path}: found a refimpl {str(found)[:40]} file, needed {kind}")
    if header.get("version") != version:
        raise FormatError(f"{path}: found version {str(header.get('version'))[:20]} of the "
                          f"{format_name} format, needed version {version}; was it written by "
                          "another release? Make it again with this one")
    told = header["facts"] if isinstance(header.get("facts"), dict) else {}
    missing = [name for name in needed if name not in arrays]
    missing += [name for name, want in dict(facts).items() if not _is_fact(told.get(name), want)]
    if missing:
        raise FormatError(f"{path}: found no {', '.join(missing)} of the right kind, needed "
                          f"{', '.join([*needed, *dict(facts)])}")
    return arrays, told


def read_bytes(path: str | Path, most: int) -> bytes:
    """The bytes of a file or a pipe.   Raises FormatError for more than `most`, OSError."""
    data = bytearray()
    with open(path, "rb") as file:
        size = os.fstat(file.fileno()).st_size
        while size <= most and (piece := file.read(1 << 20)):
            data += piece
            size = max(size, len(data))
    if size > most:
        raise FormatError(f"{path}: found more than {most} bytes, needed a file of at most that")
    return bytes(data)


def read_arrays(data: bytes, *, names: Iterable[str] | None = None,
                most: int = 0) -> dict[str, np.ndarray]:
    """The arrays of the bytes of an `.npz` file; one in Fortran order comes back in that order.

    names : those that are wanted, all unless given
    most : bytes that a compressed member may have once it is decompressed; 0 for none at all
    Raises ValueError for anything else.
    """
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            members = archive.infolist()
            if len({info.filename for info in members}) != len(members):
                raise ValueError("a member stands twice in the archive")
            named = {info.filename.removesuffix(".npy"): info for info in members}
            return {name: _read_array(archive, info, most) for name, info in named.items()
                    if names is None or name in names}
    except Exception as error:                               # zipfile and NumPy raise some 15 kinds
        raise ValueError((str(error).splitlines() or [type(error).__name__])[0][:120]) from None


def read_npy(data: bytes) -> np.ndarray:
    """The array of numbers of an `.npy` file, as long as its header says.   Raises ValueError."""
    return _array_of(io.BytesIO(data), len(data), "the file")


def plausible(array: np.ndarray) -> bool:
    """Whether all numbers are finite and of a size that motion or trained weights have.

    >>> plausible(np.array([1.0, -3e8])), plausible(np.array([np.nan]))
    (True, False)
    """
    return array.dtype.kind in "fiub" and bool((np.abs(array) <= LARGEST).all())


def _is_fact(value, kind):
    """A finite number above 0 for float, else a value of that type; a list holds words."""
    if kind is float:
        return isinstance(value, float) and 0 < value < float("inf")
    return isinstance(value, kind) and (kind is not list
                                        or all(isinstance(word, str) for word in value))


def _read_array(archive, info, most):
    """One `.npy` member as long as its own header says, compressed up to `most` bytes."""
    member_name = f"member {info.filename[:40]!r}"
    allowed = info.compress_type == zipfile.ZIP_STORED or (
        info.compress_type == zipfile.ZIP_DEFLATED and info.file_size <= most)
    if not allowed or not info.filename.endswith(".npy"):
        raise ValueError(f"{member_name} is no plain .npy array")
    with archive.open(info) as member:
        return _array_of(member, info.file_size, member_name)


def _array_of(file, most, name):
    version = np.lib.format.read_magic(file)
    if version not in ((1, 0), (2, 0)):
        raise ValueError(f"{name} has an unknown .npy version")
    shape, fortran, dtype = (np.lib.format.read_array_header_1_0 if version == (1, 0) else
                             np.lib.format.read_array_header_2_0)(file)
    size = math.prod(shape) * dtype.itemsize
    if dtype.kind not in "fiubU" or size > most:
        raise ValueError(f"{name} is no array of numbers, or shorter than it claims")
    data = file.read(most + 1)                               # to the end: verifies the checksum
    if len(data) != size:
        raise ValueError(f"{name} is longer or shorter than it claims")
    array = np.frombuffer(data, dtype).reshape(shape, order="F" if fortran else "C")
    return array.copy(order="K")
