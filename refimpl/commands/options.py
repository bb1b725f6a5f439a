"""Kinds of option values: argparse types that refuse what makes no sense, and say what does."""

import argparse
import math


def whole(least, most=10 ** 9):
    """A whole number from `least` to `most`.   ->  str -> int"""
    def read(text):
        if not text.isascii() or not text.isdigit() or len(text) > 10 or not least <= int(text) <= most:
            raise argparse.ArgumentTypeError(f"found {text!r}, needed a whole number from {least} on")
        return int(text)
    return read


def number(*, least=None, above=None, below=None):
    """A finite number within the bounds that are given.   ->  str -> float"""
    bounds = [word.format(bound) for word, bound in (("from {:g} on", least), ("above {:g}", above), ("below {:g}", below)) if bound is not None]

    def read(text):
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if not math.isfinite(value) or (least is not None and value < least) or (above is not None and value <= above) or (
                below is not None and value >= below):
            raise argparse.ArgumentTypeError(f"found {text!r}, needed a number {' and '.join(bounds)}")
        return value
    return read
