"""The HIERARCHY part of a BVH file, read and written: a tree of joints, each with an OFFSET from
its parent and a list of CHANNELS.
"""

from collections.abc import Iterable, Sequence
from dataclasses import replace
import math
import re
from typing import NoReturn

import numpy as np

from .clip import POSITION_CHANNELS, ROTATION_CHANNELS, BVHError, Joint

_CHANNELS = {name.lower(): name for name in POSITION_CHANNELS + ROTATION_CHANNELS}
_NUMBER = re.compile(r"[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?\Z")
_DEEPEST_INDENT = 40         # tabs; a chain of n joints would take n^2 of them


def is_number(word: str) -> bool:
    """Whether a word is a finite decimal number as files have it.

    >>> is_number("-1.5e3"), is_number("1_0"), is_number("nan"), is_number("1e999")
    (True, False, False, False)
    """
    return bool(_NUMBER.match(word)) and math.isfinite(float(word))


def quote(text: str) -> str:
    """A piece of a file for a message, not too long."""
    return repr(text if len(text) <= 40 else text[:37] + "...")


def decimals(numbers: Iterable[float]) -> str:
    """The shortest decimals without an exponent that are read back as the same doubles.

    >>> decimals([0.1, 1e-7, 2.0])
    '0.1 0.0000001 2'
    """
    words = map(repr, map(float, numbers))
    return " ".join(np.format_float_positional(float(word), trim="-") if "e" in word
                    else word.removesuffix(".0") for word in words)


def read_hierarchy(lines: Iterable[tuple[int, str]], name: str, end_line: int,
                   has_motion: bool) -> tuple[Joint, ...]:
    """The joints of a file, in its order. It is read without recursion, so that depth is bounded by
    memory alone.

    lines : (number, text) of the part;  name : the file's, for messages
    end_line : the number of the line after it;  has_motion : whether MOTION stands there
    Raises BVHError.

    >>> text = "HIERARCHY ROOT hips { OFFSET 0 9 0 CHANNELS 1 Xrotation End Site { OFFSET 0 1 0 } }"
    >>> read_hierarchy([(1, text)], "a file", 2, True)[0].end_site
    (0.0, 1.0, 0.0)
    """
    return _Reader(lines, name, end_line, has_motion).read()


class _Reader:
    """The tokens of the part, one after the other, each with its line, and the joints so far."""

    def __init__(self, lines: Iterable[tuple[int, str]], name: str, end_line: int,
                 has_motion: bool):
        self.tokens = [(token, number) for number, text in lines
                       for token in re.findall(r"[{}]|[^\s{}]+", text)]
        self.at, self.name = 0, name
        self.end_line, self.end = end_line, "MOTION" if has_motion else "the end of the file"
        self.joints: list[Joint] = []
        self.open_joints: list[int] = []
        self.named: dict[str, int] = {}          # the line of each name

    def read(self) -> tuple[Joint, ...]:
        """The whole part."""
        self._expect("HIERARCHY")
        self._expect("ROOT")
        self._open_joint("ROOT")
        while self.open_joints:
            keyword = self._take("JOINT, End Site or }").upper()
            if keyword == "JOINT":
                self._open_joint("JOINT")
            elif keyword == "END":
                self._read_end_site(self.open_joints[-1])
            elif keyword == "}":
                self.open_joints.pop()
            else:
                self._refuse("JOINT, End Site or }")
        if self.at < len(self.tokens):
            self.at += 1
            self._refuse("MOTION after the one ROOT's closing brace")
        if self.end != "MOTION":
            self._fail(self.end, "MOTION")
        return tuple(self.joints)

    def _open_joint(self, keyword):
        line, name = self._line(), " ".join(self._words())
        if not name:
            self._fail("no name", f"a name after {keyword}")
        if name in self.named:
            self._fail(f"a second joint named {quote(name)} (the first is in line "
                       f"{self.named[name]})", "a name of its own", line)
        self.named[name] = line
        self._expect("{")
        offset, channels = self._read_offset(name), self._read_channels(name)
        parent = self.open_joints[-1] if self.open_joints else -1
        self.open_joints.append(len(self.joints))
        self.joints.append(Joint(name, parent, offset, channels))

    def _read_end_site(self, index):
        self._expect("SITE")
        if self.joints[index].end_site is not None:
            self._fail("a second End Site",
                       f"one End Site at most below {self.joints[index].name}")
        self._words()                            # some writers name their End Sites
        self._expect("{")
        end_site = self._read_offset("an End Site")
        self.joints[index] = replace(self.joints[index], end_site=end_site)
        self._expect("}")

    def _read_offset(self, owner):
        self._expect("OFFSET")
        return tuple(self._read_number(f"the OFFSET of {owner}") for _ in range(3))

    def _read_number(self, what):
        token = self._take(what)
        if not is_number(token):
            self._refuse(f"a finite number for {what}")
        return float(token)

    def _read_channels(self, owner):
        if self.at < len(self.tokens) and self.tokens[self.at][0].upper() != "CHANNELS":
            return ()
        self._expect("CHANNELS")
        count = self._take("the number of channels")
        if count not in ("0", "1", "2", "3", "4", "5", "6"):
            self._refuse(f"a number of channels from 0 to 6 for {owner}")
        channels: list[str] = []
        for _ in range(int(count)):
            channel = _CHANNELS.get(self._take(f"{count} channel names for {owner}").lower())
            if channel is None or channel in channels:
                self._refuse("a channel not listed before, one of " + " ".join(_CHANNELS.values()))
            channels.append(channel)
        return tuple(channels)

    def _words(self):
        """What stands before the next brace."""
        start = self.at
        while self.at < len(self.tokens) and self.tokens[self.at][0] not in "{}":
            self.at += 1
        return [token for token, _ in self.tokens[start:self.at]]

    def _expect(self, word):
        if self._take(word).upper() != word:
            self._refuse(word)

    def _take(self, needed):
        if self.at == len(self.tokens):
            self._fail(self.end, needed)
        self.at += 1
        return self.tokens[self.at - 1][0]

    def _refuse(self, needed) -> NoReturn:
        """Fail at the token that was taken last."""
        self.at -= 1
        self._fail(quote(self.tokens[self.at][0]), needed)

    def _fail(self, found, needed, line=None) -> NoReturn:
        raise BVHError(f"{self.name}:{line or self._line()}: found {found}, needed {needed}")

    def _line(self):
        return self.tokens[self.at][1] if self.at < len(self.tokens) else self.end_line


def hierarchy_lines(joints: Sequence[Joint]) -> list[str]:
    """The lines of the part, HIERARCHY first.

    joints : in depth-first order below one root, or a BVHError is raised
    """
    lines = ["HIERARCHY"]
    open_joints: list[int] = []

    def _tab():
        return "\t" * min(len(open_joints), _DEEPEST_INDENT)

    def _close():
        end_site = joints[open_joints[-1]].end_site
        if end_site is not None:
            lines.extend(_tab() + line for line in
                         ("End Site", "{", f"\tOFFSET {decimals(end_site)}", "}"))
        open_joints.pop()
        lines.append(_tab() + "}")

    for index, joint in enumerate(joints):
        while open_joints and open_joints[-1] != joint.parent:
            _close()
        if (joint.parent == -1) != (index == 0) or (index and not open_joints):
            raise BVHError(f"joint {joint.name!r}: found parent {joint.parent}, needed joints in "
                           "depth-first order below one root")
        channels = " ".join([str(len(joint.channels)), *joint.channels])
        lines.extend(_tab() + line for line in
                     (f"{'JOINT' if open_joints else 'ROOT'} {joint.name}", "{",
                      f"\tOFFSET {decimals(joint.offset)}", f"\tCHANNELS {channels}"))
        open_joints.append(index)
    while open_joints:
        _close()
    return lines
