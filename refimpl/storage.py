"""Files on disk: written whole or not at all.

A file that is being written lives under a temporary name in the same folder; only when every byte is on the disk does it
take its real name. Whoever looks, at any moment, finds the old file or the new one and never half of one.
"""

import contextlib
import json
import os
from pathlib import Path
import tempfile
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
        np.savez(file, header=np.array(header), **arrays)


def load_npz(path, format_name, version, needed):
    """Read what `save_npz` wrote.

    needed : names of the arrays that must be there   ->  ({name: array}, facts)
    Raises FormatError (foreign, truncated, of another format or a newer version, an array missing) or OSError.
    """
    kind = f"a refimpl {format_name} file"
    try:
        with np.load(path, allow_pickle=False) as archive:
            if not isinstance(archive, np.lib.npyio.NpzFile) or "header" not in archive.files:
                raise FormatError(f"{path}: found a file without a refimpl header, needed {kind}")
            header = json.loads(str(archive["header"]))
            if not isinstance(header, dict) or header.get("format") != format_name:
                found = header.get("format") if isinstance(header, dict) else header
                raise FormatError(f"{path}: found a refimpl {found} file, needed {kind}")
            if header.get("version") != version:
                raise FormatError(f"{path}: found version {header.get('version')} of the {format_name} format, needed version "
                                  f"{version}; was it written by another release? Make it again with this one")
            missing = [name for name in needed if name not in archive.files]
            if missing:
                raise FormatError(f"{path}: found no array {', '.join(missing)}, needed {', '.join(needed)}")
            return {name: archive[name] for name in archive.files if name != "header"}, header["facts"]
    except FormatError:
        raise
    except (ValueError, KeyError, EOFError, zipfile.BadZipFile, zlib.error, NotImplementedError) as error:
        raise FormatError(f"{path}: found something else or a damaged file ({_first_line(error)}), needed {kind}") from None


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
