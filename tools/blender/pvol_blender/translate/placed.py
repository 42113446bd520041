"""What a depsgraph shows, object by object and instance by instance."""

from typing import Any, NamedTuple


class Placed(NamedTuple):
    object: Any  # evaluated
    matrix: Any  # to the world; a copy, which outlives the depsgraph's
    key: tuple  # the same in the next frame
    name: str  # for messages
    owner: Any  # the original object that the artist sees: of an instance, its instancer


def things(depsgraph):
    """Everything that is visible, instances included."""
    for instance in depsgraph.object_instances:
        if not instance.show_self:
            continue
        thing = instance.object
        owner = instance.parent.original if instance.is_instance else thing.original
        key = (owner.name_full, thing.name_full, tuple(instance.persistent_id))
        yield Placed(thing, instance.matrix_world.copy(), key, owner.name, owner)
