"""Paths of prims, from names of Blender's data."""


def path(kind, *parts):
    """/kind/part/part; a slash in a name makes no level of its own."""
    return "/".join(["", kind, *(part.replace("%", "%25").replace("/", "%2F") for part in parts)])


def matrix(blender):
    """Rows of Blender's matrix, which acts on columns, as those of ours, which acts on rows."""
    return [list(column) for column in zip(*blender)]
