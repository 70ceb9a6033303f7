"""What pydantic found wrong, in the words of a scene's author."""

from typing import Annotated, get_args, get_origin

from pydantic import ValidationError

from .errors import NAMED_TABLES, Problem, did_you_mean, key_text, listed, show

# Begins those steps of a pydantic location that name a member of a union.
TAG = "\0"

MOST_KEYS = 20
"""Of a table that are named where one is unknown: those of the whole scene are 16."""


def problems_of(error, cls, data):
    """The problems in a pydantic ValidationError, raised when `data` was to become a `cls`."""
    problems = []
    for found in _errors(error):
        # a default that waits on a value which has its own message
        if found["type"] == "default_factory_not_called":
            continue

        path, value = _path(found["loc"], data), found["input"]
        text = _text(found, cls)
        if len(path) == 2 == len(found["loc"]) and path[0] in NAMED_TABLES and not isinstance(value, dict):
            # a key right below [body]
            text = f"needs a table of its own, [{path[0]}.NAME]; found {show(value)}"
        problems.append(Problem(path, text))
    return problems


def _errors(error):
    """Those of a ValidationError, those of the parts inside (fields.Part) at their places."""
    for found in error.errors(include_url=False):
        inner = found.get("ctx", {}).get("error")

        if isinstance(inner, ValidationError):
            for deeper in _errors(inner):
                yield deeper | {"loc": (*found["loc"], *deeper["loc"])}
        else:
            yield found


def _path(location, data):
    """A pydantic location as a path of keys as the author wrote them."""
    path = []
    for step in location:
        if isinstance(step, str) and (step.startswith(TAG) or step == "[key]"):
            continue
        # a single solid may stand without the list
        if isinstance(step, int) and not isinstance(data, (list, tuple)):
            continue

        path.append(step)
        try:
            data = data[step]
        except (TypeError, KeyError, IndexError):
            data = None
    return tuple(path)


def _text(found, cls):
    """One of pydantic's errors, in words."""
    kind, location, value = found["type"], found["loc"], found["input"]

    if kind == "value_error":
        return str(found["ctx"]["error"])
    if kind == "extra_forbidden":
        return _unknown_key(_part_at(cls, location[:-1]), str(location[-1]), value)
    if kind == "missing":
        field = _part_at(cls, location[:-1]).model_fields[location[-1]]
        return f"is missing ({field.description})" if field.description else "is missing"
    if kind in ("model_type", "dict_type", "model_attributes_type"):
        return f"needs a table, found {show(value)}"
    return f"{found['msg']}, found {show(value)}"


def _unknown_key(part, key, value):
    keys = part.known_keys()
    known = f"there is {listed(keys, limit=MOST_KEYS)}" if keys else "this table has none"
    text = f"unknown key; {known}.{did_you_mean(key, keys)}"
    if "marker" in keys and isinstance(value, dict):
        text += f" A marker is written marker.{key_text(key)} = {{ ... }}."
    return text


def _part_at(annotation, location):
    """The Part class that checks what is at a pydantic location below a type, or None."""
    # an Annotated type passes on the attributes of what it annotates
    if isinstance(annotation, type) and hasattr(annotation, "model_fields"):
        if not location:
            return annotation
        field = annotation.model_fields.get(location[0])
        return field and _part_at(field.annotation, location[1:])

    arguments = get_args(annotation)
    origin = get_origin(annotation)
    if origin is Annotated:
        tag = next((t.tag for t in annotation.__metadata__ if hasattr(t, "tag")), None)
        if tag is not None:
            if not location or location[0] != tag:
                return None
            location = location[1:]
        return _part_at(arguments[0], location)
    if origin is dict:
        return _part_at(arguments[1], location[1:])
    if origin is list:
        return _part_at(arguments[0], location[1:])

    # a union: of its members only the right one is found
    return next(filter(None, (_part_at(member, location) for member in arguments)), None)
