"""Shader nodes: what is linked to a socket, and constants."""

from .blackbody import blackbody_color


def source(socket):
    """The node and socket that feed a socket, past reroutes; None where nothing does."""
    while socket is not None and socket.is_linked:
        link = socket.links[0]
        if link.from_node.type != "REROUTE":
            return None if link.from_node.mute else (link.from_node, link.from_socket)
        socket = link.from_node.inputs[0]
    return None


def value(node, name, default=None):
    """The constant of an input: a number, or a list of three for colours."""
    socket = node.inputs.get(name)
    if socket is None:
        return default
    constant = socket.default_value
    return list(constant)[:3] if hasattr(constant, "__len__") and not isinstance(
        constant, str) else constant


def color(node, name):
    """The colour of an input and whether it is a constant: so are RGB and Blackbody nodes."""
    fed = source(node.inputs[name])
    if fed is None:
        return value(node, name), True
    feeder, socket = fed
    if feeder.type == "RGB":
        return list(socket.default_value)[:3], True
    if feeder.type == "BLACKBODY" and not feeder.inputs[0].is_linked:
        return list(blackbody_color(feeder.inputs[0].default_value)), True
    return value(node, name), False


def number(node, name):
    """The number of an input and whether it is a constant: so are Value nodes."""
    fed = source(node.inputs[name])
    if fed is None:
        return value(node, name), True
    feeder, socket = fed
    if feeder.type == "VALUE":
        return socket.default_value, True
    return value(node, name), False


def output(tree, kind, name):
    """The node that feeds an input of the active output, such as ("OUTPUT_WORLD", "Surface")."""
    found = [n for n in tree.nodes if n.type == kind]
    active = [n for n in found if n.is_active_output]
    for node in active or found:
        fed = source(node.inputs[name])
        if fed is not None:
            return fed[0]
    return None
