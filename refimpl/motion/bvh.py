"""Reading and writing BVH files.

A BVH file is a tree of joints, each with an OFFSET from its parent and a list of CHANNELS, followed by one line of numbers a
frame: all channels of all joints in the order of the file. What the format leaves open is decided here:

- position channels *replace* the joint's OFFSET along their axis, on the root and on any other joint;
- rotation channels are intrinsic rotations in the order listed, in degrees; every joint has its own order;
- an End Site is where a joint's last bone ends; it has no channels;
- a name is everything between the keyword and the brace, so that names with spaces survive;
- keywords are read in any case; lines that begin with `#` are comments.

A file that cannot be read exactly is refused with a `BVHError` that names the file, the line, what was found and what was needed.
"""

import io
import math
import re

import numpy as np

from ..storage import atomic_write
from .clip import POSITION_CHANNELS, ROTATION_CHANNELS, BVHError, Clip, Joint

_CHANNELS = {name.lower(): name for name in POSITION_CHANNELS + ROTATION_CHANNELS}
_NUMBER = re.compile(r"[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?\Z")
LONGEST_LINE = 1 << 24                                           # characters; 10,000 joints with all channels need a tenth of it
SHORTEST_FRAME, LONGEST_FRAME = 1e-6, 1e6                        # seconds


def read_bvh(path):
    """Read a BVH file.   path  ->  Clip.   Raises BVHError (malformed content) or OSError (no such file, no permission).

    Line by line, so that a file with an endless line is refused before it fills the memory.
    """
    try:
        with open(path, encoding="utf-8-sig") as file:
            return _parse(_numbered_lines(file, path), path)
    except UnicodeDecodeError:
        raise _encoding_error(path) from None


def parse_bvh(text, name="<text>"):
    """Parse the text of a BVH file; `name` stands for the file in error messages.   ->  Clip"""
    return _parse(_numbered_lines(io.StringIO(text.removeprefix("\ufeff"), newline=None), name), name)


def _numbered_lines(file, name):
    """(number, text) of every line that is neither empty nor a comment, and at last (number of lines, None)."""
    number = 0
    while line := file.readline(LONGEST_LINE + 1):
        number += 1
        if len(line) > LONGEST_LINE:
            raise BVHError(f"{name}:{number}: found a line of more than {LONGEST_LINE} characters, needed one line a frame; is this a BVH file?")
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
                return BVHError(f"{path}:{number}: found byte 0x{line[error.start]:02x}, needed UTF-8 text; "
                                "is this a BVH file? If it is, save it as UTF-8")
    return BVHError(f"{path}:1: found bytes that are no UTF-8, needed UTF-8 text")


def _parse(lines, name):
    header = []
    for number, text in lines:
        if text is None:
            if not header:
                raise BVHError(f"{name}:1: found an empty file, needed HIERARCHY")
            return _Header(header, name, number, False).read()   # raises: there is no MOTION
        if text.strip().upper() == "MOTION":
            return _parse_motion(lines, tuple(_Header(header, name, number, True).read()), name)
        header.append((number, text))


class _Header:
    """The tokens of the HIERARCHY part, one after the other, each with its line."""

    def __init__(self, lines, name, end_line, has_motion):
        """lines : (number, text) up to MOTION or, without one, to the end;  end_line : the number of the line that ends it"""
        self.name, self.end_line, self.has_motion, self.at = name, end_line, has_motion, 0
        self.tokens = [(token, number) for number, text in lines for token in re.findall(r"[{}]|[^\s{}]+", text)]

    def fail(self, found, needed, line=None):
        raise BVHError(f"{self.name}:{line or self._line_here()}: found {found}, needed {needed}")

    def _line_here(self):
        return self.tokens[self.at][1] if self.at < len(self.tokens) else self.end_line

    def take(self, needed):
        if self.at >= len(self.tokens):
            self.fail("MOTION" if self.has_motion else "the end of the file", needed)
        token = self.tokens[self.at][0]
        self.at += 1
        return token

    def expect(self, *words):
        start = self.at
        for word in words:
            token = self.take(word)
            if token.upper() != word:
                self.at = start
                self.fail(_quote(token), " ".join(words))

    def number(self, what):
        token = self.take(what)
        if not _NUMBER.match(token) or not math.isfinite(float(token)):
            self.at -= 1
            self.fail(_quote(token), f"a finite number for {what}")
        return float(token)

    def read_name(self, keyword):
        words = []
        while self.at < len(self.tokens) and self.tokens[self.at][0] not in "{}":
            words.append(self.take("a name"))
        if not words:
            self.fail("no name", f"a name after {keyword}")
        return " ".join(words)

    def read_offset(self, owner):
        self.expect("OFFSET")
        return tuple(self.number(f"the OFFSET of {owner}") for _ in range(3))

    def read_channels(self, owner):
        if self.at < len(self.tokens) and self.tokens[self.at][0].upper() != "CHANNELS":
            return ()
        self.expect("CHANNELS")
        count = self.take("the number of channels")
        if count not in ("0", "1", "2", "3", "4", "5", "6"):
            self.at -= 1
            self.fail(_quote(count), f"a number of channels from 0 to 6 for {owner}")
        channels = []
        for _ in range(int(count)):
            word = self.take(f"{count} channel names for {owner}")
            if word.lower() not in _CHANNELS or _CHANNELS[word.lower()] in channels:
                self.at -= 1
                self.fail(_quote(word), "a channel not listed before, one of " + " ".join(_CHANNELS.values()))
            channels.append(_CHANNELS[word.lower()])
        return tuple(channels)

    def read(self):
        """The whole hierarchy without recursion, so that depth is bounded by memory alone."""
        self.expect("HIERARCHY")
        self.expect("ROOT")
        joints, open_joints = [], []
        seen = {}
        self._open(joints, open_joints, seen, "ROOT")
        while open_joints:
            token = self.take("JOINT, End Site or }").upper()
            if token == "JOINT":
                self._open(joints, open_joints, seen, "JOINT")
            elif token == "END":
                self._end_site(joints, open_joints[-1])
            elif token == "}":
                open_joints.pop()
            else:
                self.at -= 1
                self.fail(_quote(self.tokens[self.at][0]), "JOINT, End Site or }")
        if self.at < len(self.tokens):
            self.fail(_quote(self.tokens[self.at][0]), "MOTION after the one ROOT's closing brace")
        if not self.has_motion:
            self.fail("the end of the file", "MOTION")
        return joints

    def _open(self, joints, open_joints, seen, keyword):
        line = self._line_here()
        name = self.read_name(keyword)
        if name in seen:
            self.fail(f"a second joint named {_quote(name)} (the first is in line {seen[name]})", "a name of its own", line)
        seen[name] = line
        self.expect("{")
        offset = self.read_offset(name)
        joints.append(Joint(name, open_joints[-1] if open_joints else -1, offset, self.read_channels(name)))
        open_joints.append(len(joints) - 1)

    def _end_site(self, joints, index):
        self.expect("SITE")
        if joints[index].end_site is not None:
            self.fail("a second End Site", f"one End Site at most below {joints[index].name}")
        while self.at < len(self.tokens) and self.tokens[self.at][0] not in "{}":
            self.at += 1                                        # some writers name their End Sites
        self.expect("{")
        joint = joints[index]
        joints[index] = Joint(joint.name, joint.parent, joint.offset, joint.channels, self.read_offset("an End Site"))
        self.expect("}")


def _parse_motion(lines, joints, name):
    """The MOTION part: Frames, Frame Time and the table of numbers."""
    number, frames = _labelled(lines, "Frames:", name)
    if not re.fullmatch(r"0*[1-9][0-9]{0,8}", frames):
        raise BVHError(f"{name}:{number}: found Frames: {_quote(frames)}, needed a whole number of frames from 1 on")
    number, frame_time = _labelled(lines, "Frame Time:", name)
    if not _NUMBER.match(frame_time) or not SHORTEST_FRAME <= float(frame_time) <= LONGEST_FRAME:
        raise BVHError(f"{name}:{number}: found Frame Time: {_quote(frame_time)}, needed seconds a frame above 0, "
                       f"from {SHORTEST_FRAME:g} to {LONGEST_FRAME:g}")
    width, rows = sum(len(joint.channels) for joint in joints), []
    for number, text in lines:
        if text is None:
            break
        if len(rows) == int(frames):
            raise BVHError(f"{name}:{number}: found more rows of motion, needed {int(frames)} as Frames: says")
        rows.append(_parse_row(text, width, f"{name}:{number}"))
    if len(rows) < int(frames):
        raise BVHError(f"{name}:{number}: found {len(rows)} rows of motion, needed {int(frames)} as Frames: says; was the file cut off?")
    return Clip(joints, float(frame_time), np.array(rows).reshape(len(rows), width))


def _parse_row(text, width, where):
    """One line of numbers.   ->  (width,) float64"""
    words = text.split(None, width)                              # what is too much stays in one piece
    if len(words) != width:
        found = len(words) if len(words) < width else f"more than {width}"
        raise BVHError(f"{where}: found {found} values, needed {width}, one for each channel")
    try:
        row = np.array(words, dtype=float)
        good = np.isfinite(row).all() and "_" not in text and text.isascii()
    except ValueError:
        good = False
    if not good:
        bad = [w for w in words if not _NUMBER.match(w) or not math.isfinite(float(w))]
        if bad:
            raise BVHError(f"{where}: found {_quote(bad[0])}, needed a finite number")
    return row


def _labelled(lines, label, name):
    """The number of the next line and the text behind a label such as `Frames:`, written in any case and with any white space."""
    number, text = next(lines)
    if text is None:
        raise BVHError(f"{name}:{number}: found the end of the file, needed {label}")
    match = re.match(r"\s*" + r"\s+".join(label.split()) + r"\s*(.*?)\s*\Z", text, re.IGNORECASE)
    if not match:
        raise BVHError(f"{name}:{number}: found {_quote(text.strip())}, needed {label}")
    return number, match.group(1)


def _quote(text):
    return repr(text if len(text) <= 40 else text[:37] + "...")


def write_bvh(path, clip):
    """Write a clip; what is read back is equal to the last bit, and no number needs an exponent.

    The file appears whole or not at all. Raises OSError when it cannot be written, BVHError when the clip's parts disagree or would
    be read back as something else (a name with a space in it, two joints of one name, a frame time of 0).
    """
    with atomic_write(path) as file:
        file.write(format_bvh(clip))


def format_bvh(clip):
    """The text of a BVH file.   Clip  ->  str"""
    width = sum(len(joint.channels) for joint in clip.joints)
    if clip.values.ndim != 2 or clip.values.shape[1] != width or not len(clip.values):
        raise BVHError(f"clip.values: found shape {clip.values.shape}, needed (frames, {width}) with at least one frame")
    if not np.isfinite(clip.values).all():
        frame, channel = np.argwhere(~np.isfinite(clip.values))[0]
        raise BVHError(f"clip.values: found {clip.values[frame, channel]} in frame {frame}, channel {channel}, "
                       "needed finite numbers")
    header, time = ["HIERARCHY", *_hierarchy_lines(clip.joints), "MOTION"], f"Frame Time:\t{_decimal(clip.frame_time)}"
    _check_header([*header, "Frames:\t1", time, _row(clip.values[0])], clip)
    return "\n".join([*header, f"Frames:\t{clip.frames}", time, *map(_row, clip.values)]) + "\n"


def _check_header(lines, clip):
    """The reader must find the same joints and frame time again, or nobody can."""
    try:
        again = parse_bvh("\n".join(lines) + "\n", "the clip")
    except BVHError as error:
        raise BVHError(f"clip: found something that cannot be read again, needed what the format can hold ({error})") from None
    if again.joints != tuple(clip.joints) or again.frame_time != clip.frame_time:
        changed = [joint.name for joint, other in zip(clip.joints, again.joints) if joint != other]
        raise BVHError(f"clip: found {', '.join(map(repr, changed[:3]))}, needed joints and a frame time that are read back as they are")


def _hierarchy_lines(joints):
    lines, open_joints = [], []

    def close():
        joint = joints[open_joints[-1]]
        tab = _indent(open_joints)
        if joint.end_site is not None:
            lines.extend([f"{tab}End Site", tab + "{", f"{tab}\tOFFSET {_row(joint.end_site)}", tab + "}"])
        open_joints.pop()
        lines.append(_indent(open_joints) + "}")

    for index, joint in enumerate(joints):
        while open_joints and open_joints[-1] != joint.parent:
            close()
        if (joint.parent == -1) != (index == 0) or (index and not open_joints):
            raise BVHError(f"joint {joint.name!r}: found parent {joint.parent}, needed joints in depth-first order below one root")
        tab = _indent(open_joints)
        lines.extend([f"{tab}{'JOINT' if open_joints else 'ROOT'} {joint.name}", tab + "{", f"{tab}\tOFFSET {_row(joint.offset)}"])
        lines.append(f"{tab}\tCHANNELS {' '.join([str(len(joint.channels)), *joint.channels])}")
        open_joints.append(index)
    while open_joints:
        close()
    return lines


def _indent(open_joints):
    """Tabs to show the depth; no more than 40, or a chain of n joints would take n^2 of them."""
    return "\t" * min(len(open_joints), 40)


def _row(numbers):
    return " ".join(map(_decimal, numbers))


def _decimal(x):
    """The shortest decimal without an exponent that reads back as the same double."""
    return np.format_float_positional(x, trim="-")
