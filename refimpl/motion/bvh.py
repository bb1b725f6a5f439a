"""Reading and writing BVH files.

A BVH file is a tree of joints, each with an OFFSET from its parent and a list of CHANNELS, followed
by one line of numbers a frame: all channels of all joints in the order of the file. What the format
leaves open is decided here:

- position channels *replace* the joint's OFFSET along their axis, on the root and on any other
  joint;
- rotation channels are intrinsic rotations in the order listed, in degrees; every joint has its own
  order;
- an End Site is where a joint's last bone ends; it has no channels;
- a name is everything between the keyword and the brace, so that names with spaces survive;
- keywords are read in any case; lines that begin with `#` are comments.

A file that cannot be read exactly is refused with a `BVHError` that names the file, the line, what
was found and what was needed.
"""

from collections.abc import Iterator
import io
from pathlib import Path
import re
from typing import TextIO

import numpy as np

from ..storage import atomic_write
from .clip import POSITION_CHANNELS, ROTATION_CHANNELS, BVHError, Clip, Joint  # noqa: F401
from .hierarchy import decimals, hierarchy_lines, is_number, quote, read_hierarchy

LONGEST_LINE = 1 << 24           # characters; 10,000 joints with all channels need a tenth of it
SHORTEST_FRAME, LONGEST_FRAME = 1e-6, 1e6        # seconds


def read_bvh(path: str | Path) -> Clip:
    """Read a BVH file.

    Line by line, so that a file with an endless line is refused before it fills the memory.

    path : the file  ->  Clip
    Raises BVHError (malformed content) or OSError (no such file, no permission).
    """
    try:
        with open(path, encoding="utf-8-sig") as file:
            return _parse(_numbered_lines(file, path), path)
    except UnicodeDecodeError:
        raise _encoding_error(path) from None


def parse_bvh(text: str, name: str = "<text>") -> Clip:
    """Parse the text of a BVH file.

    text : all of it;  name : stands for the file in messages   ->  Clip.   Raises BVHError.

    >>> head = "HIERARCHY\\nROOT hips\\n{\\nOFFSET 0 0 0\\nCHANNELS 1 Yposition\\n}\\n"
    >>> parse_bvh(head + "MOTION\\nFrames: 2\\nFrame Time: 0.5\\n90\\n91\\n").values
    array([[90.],
           [91.]])
    """
    file = io.StringIO(text.removeprefix("\ufeff"), newline=None)
    return _parse(_numbered_lines(file, name), name)


def _numbered_lines(file: TextIO, name) -> Iterator[tuple[int, str | None]]:
    """(number, text) of every line that is neither empty nor a comment, and at last (number of
    lines, None).
    """
    number = 0
    while line := file.readline(LONGEST_LINE + 1):
        number += 1
        if len(line) > LONGEST_LINE:
            raise BVHError(f"{name}:{number}: found a line of more than {LONGEST_LINE} characters, "
                           "needed one line a frame; is this a BVH file?")
        if line.strip() and not line.lstrip().startswith("#"):
            yield number, line
    yield number, None


def _encoding_error(path):
    """The BVHError that names the line of the first byte that is no UTF-8."""
    with open(path, "rb") as file:
        for number, line in enumerate(iter(lambda: file.readline(LONGEST_LINE), b""), start=1):
            try:
                line.decode("utf-8")
            except UnicodeDecodeError as error:
                return BVHError(
                    f"{path}:{number}: found byte 0x{line[error.start]:02x}, needed UTF-8 text; "
                    "is this a BVH file? If it is, save it as UTF-8")
    return BVHError(f"{path}:1: found bytes that are no UTF-8, needed UTF-8 text")


def _parse(lines, name):
    header: list[tuple[int, str]] = []
    for number, text in lines:
        if text is not None and text.strip().upper() != "MOTION":
            header.append((number, text))
            continue
        if text is None and not header:
            raise BVHError(f"{name}:1: found an empty file, needed HIERARCHY")
        joints = read_hierarchy(header, name, number, text is not None)
        return _parse_motion(lines, joints, name)


def _parse_motion(lines, joints, name):
    """The MOTION part: Frames, Frame Time and the table of numbers."""
    number, frames = _labelled(lines, "Frames:", name)
    counted_at = number
    if not re.fullmatch(r"0*[1-9][0-9]{0,8}", frames):
        raise BVHError(f"{name}:{number}: found Frames: {quote(frames)}, needed a whole number of "
                       "frames from 1 on")
    number, frame_time = _labelled(lines, "Frame Time:", name)
    if not is_number(frame_time) or not SHORTEST_FRAME <= float(frame_time) <= LONGEST_FRAME:
        raise BVHError(f"{name}:{number}: found Frame Time: {quote(frame_time)}, needed seconds a "
                       f"frame above 0, from {SHORTEST_FRAME:g} to {LONGEST_FRAME:g}")
    width = sum(len(joint.channels) for joint in joints)
    table, rows = np.empty((0, width)), 0
    for number, text in lines:
        if text is None:
            break
        if rows == int(frames):
            count = rows + 1 + sum(text is not None for _, text in lines)
            raise BVHError(f"{name}:{number}: found {count} rows of motion, needed {int(frames)} "
                           f"as Frames: says; write Frames: {count} in line {counted_at}, or take "
                           "rows away")
        if rows == len(table):               # grows with what is there, not with what is claimed
            longer = np.empty((min(int(frames), 2 * rows + 64), width))
            longer[:rows] = table
            table = longer
        table[rows] = _parse_row(text, width, f"{name}:{number}")
        rows += 1
    if rows < int(frames):
        raise BVHError(f"{name}:{number}: found {rows} rows of motion, needed {int(frames)} "
                       f"as Frames: says; was the file cut off? If not, write Frames: {rows} "
                       f"in line {counted_at}")
    return Clip(joints, float(frame_time), table)


def _parse_row(text, width, where):
    """One line of numbers.   ->  (width,) float64"""
    words = text.split(None, width)                  # what is too much stays in one piece
    if len(words) != width:
        found = len(words) if len(words) < width else f"more than {width}"
        raise BVHError(f"{where}: found {found} values, needed {width}, one for each channel")
    try:
        row = np.array(words, dtype=float)           # fast, and takes 1_0, nan and Arabic digits
        good = np.isfinite(row).all() and "_" not in text and text.isascii()
    except ValueError:
        good = False
    bad = [] if good else [word for word in words if not is_number(word)]
    if bad:
        raise BVHError(f"{where}: found {quote(bad[0])}, needed a finite number")
    return row


def _labelled(lines, label, name):
    """The number of the next line and the text behind a label such as `Frames:`, written in any
    case and with any white space.
    """
    number, text = next(lines)
    if text is None:
        raise BVHError(f"{name}:{number}: found the end of the file, needed {label}")
    pattern = r"\s*" + r"\s+".join(label.split()) + r"\s*(.*?)\s*\Z"
    match = re.match(pattern, text, re.IGNORECASE)
    if not match:
        raise BVHError(f"{name}:{number}: found {quote(text.strip())}, needed {label}")
    return number, match.group(1)


def write_bvh(path: str | Path, clip: Clip) -> None:
    """Write a clip; what is read back is equal to the last bit, and no number needs an exponent.

    The file appears whole or not at all.

    Raises OSError when it cannot be written, BVHError when the clip's parts disagree or would be
    read back as something else (a name with a space in it, two joints of one name, a frame time of
    0).
    """
    with atomic_write(path) as file:
        file.writelines(_written(clip))


def format_bvh(clip: Clip) -> str:
    """The text of a BVH file.   Raises BVHError, see `write_bvh`."""
    return "".join(_written(clip))


def _written(clip):
    """Its lines."""
    width = sum(len(joint.channels) for joint in clip.joints)
    if clip.values.ndim != 2 or clip.values.shape[1] != width or not len(clip.values):
        raise BVHError(f"clip.values: found shape {clip.values.shape}, needed (frames, {width}) "
                       "with at least one frame")
    if not np.isfinite(clip.values).all():
        frame, channel = np.argwhere(~np.isfinite(clip.values))[0]
        raise BVHError(f"clip.values: found {clip.values[frame, channel]} in frame {frame}, "
                       f"channel {channel}, needed finite numbers")
    header = [*hierarchy_lines(clip.joints), "MOTION"]
    frame_time = f"Frame Time:\t{decimals([clip.frame_time])}"
    first = [*header, "Frames:\t1", frame_time, decimals(clip.values[0])]
    _check_header("\n".join(first) + "\n", clip)
    for line in (*header, f"Frames:\t{clip.frames}", frame_time):
        yield line + "\n"
    for row in clip.values:                          # one at a time: an hour is 100 MB of text
        yield decimals(row) + "\n"


def _check_header(text, clip):
    """The reader must find the same joints and frame time again, or nobody can."""
    try:
        again = parse_bvh(text, "the clip")
    except BVHError as error:
        raise BVHError("clip: found something that cannot be read again, needed what the format "
                       f"can hold ({error})") from None
    if again.joints != tuple(clip.joints) or again.frame_time != clip.frame_time:
        changed = [repr(joint.name) for joint, other in zip(clip.joints, again.joints)
                   if joint != other]
        raise BVHError(f"clip: found {', '.join(changed[:3])}, needed joints and a frame time that "
                       "are read back as they are")
