"""The commands of `refimpl`: each module adds its words to the parser (`add_commands`) and prints
what it did.
"""
