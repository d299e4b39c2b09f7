"""The bodies and joints of a model file whose right half is an image of its left one, for what measures other
simulators beside ours.
"""


def parts(model, kind):
    """Bodies or joints; images are marked, since their axes are reflected."""
    mirror = model["mirror"]
    names = (mirror["from"], mirror["to"])
    for part in model[kind]:
        yield part, False
        if names[0] in part["name"]:
            yield {key: image(key, value, names) for key, value in part.items()}, True


def image(key, value, names):
    """A part of the left half as the right half has it: reflected at x = 0."""
    if isinstance(value, dict):
        return {k: image(k, v, names) for k, v in value.items()}
    if isinstance(value, str):
        return value.replace(*names) if key in ("name", "parent", "child") else value
    if key in ("position_m", "anchor_m", "from_m", "to_m"):
        return [-value[0], *value[1:]]
    return value
