"""What of a scene pvol cannot render as it is, and what it renders instead."""

from typing import NamedTuple


class Note(NamedTuple):
    thing: str  # the name of the object, material or world
    what: str  # cannot be mapped
    instead: str  # what pvol uses

    def __str__(self):
        return f"{self.thing}: {self.what}; {self.instead}"


class Notes(list):
    """Notes in the order in which they are found, each once."""

    def add(self, thing, what, instead):
        note = Note(thing, what, instead)
        if note not in self:
            self.append(note)
