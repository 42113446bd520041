"""What the tools say: tests name a message by its key in tests/messages.txt."""
import pathlib
import re

FILE = pathlib.Path(__file__).resolve().parent.parent / "messages.txt"
MESSAGES = dict(line.split(": ", 1) for line in FILE.read_text().splitlines() if line and line[0] != "#")


def message(key):
    """A regular expression of the line that is this message, in which `*` stands for anything."""
    return r"(?m)^ *" + ".*".join(map(re.escape, MESSAGES[key].split("*"))) + r" *$"
