"""The commands of `refimpl`: each module adds its words to the parser (`add_commands`) and prints
what it did.
"""

from ..lazy import opened

__getattr__, __dir__ = opened(__name__)
