"""Statements laid out as C: variables are declared where they are first given a value, and what is never read
is left out."""

import re
from dataclasses import dataclass, field

_WORD = re.compile(r"(?<![\w.])(?<!->)[A-Za-z_]\w*")


@dataclass
class Line:
    """A statement. name : of the variable that it gives a value, if it does. value : that value. sign : by
    which it is given. acts : whether the value does something besides.
    """

    text: str
    name: str = ""
    value: str = ""
    sign: str = "="
    acts: bool = False


@dataclass
class Block:
    """Statements in braces behind a head."""

    head: str
    items: list = field(default_factory=list)


def words(text: str) -> set[str]:
    """Names in a text, those of members apart."""
    return set(_WORD.findall(text))


def _mentions(item):
    """Names in an item."""
    if isinstance(item, Line):
        return words(item.text)

    return words(item.head).union(*map(_mentions, item.items))


def _reads(item):
    """Names whose values an item uses."""
    if isinstance(item, Line):
        return words(item.value) if item.name else words(item.text)

    return words(item.head).union(*map(_reads, item.items))


def without_unread(items: list, names: set[str]) -> list:
    """Statements without those that give values to variables (`names`) that nobody reads."""
    while True:
        unread = names - set().union(*map(_reads, items)) if items else set()
        found = _dropped(items, unread)

        if found == items:
            return items

        items = found


def _dropped(items, unread):
    found: list = []

    for item in items:
        if isinstance(item, Block):
            block = Block(item.head, _dropped(item.items, unread))
            empty = not block.items and not item.head.startswith(("if", "} else", "while"))

            if not empty:
                found.append(block)
        elif item.name not in unread:
            found.append(item)
        elif item.acts:
            found.append(Line(f"(void){item.value};"))

    return found


def lines(items: list, kinds: dict[str, str], depth: int = 1) -> list[str]:
    """The text of statements, variables (kinds: name -> declaration) declared in the innermost block that has
    all that is said of them.
    """
    declared, heads = {}, []

    for name, declaration in kinds.items():
        places = [k for k, item in enumerate(items) if name in _mentions(item)]

        if not places:
            continue

        first = items[places[0]]

        if (
            isinstance(first, Line)
            and first.name == name
            and first.sign == "="
            and name not in words(first.value)
        ):
            declared[places[0]] = declaration
        elif len(places) == 1 and isinstance(first, Block) and _can_go_into(first, name):
            continue
        else:
            heads.append(f"{declaration} = {'{0}' if _is_structure(declaration) else '0'};")

    here = {name for name in kinds if any(name in _mentions(item) for item in items)}
    inner = {
        name: declaration
        for name, declaration in kinds.items()
        if name in here
        and declaration not in declared.values()
        and not any(h.startswith(f"{declaration} =") for h in heads)
    }
    indent = "    " * depth
    found = [f"{indent}{head}" for head in heads]

    for k, item in enumerate(items):
        if isinstance(item, Block):
            found += [f"{indent}{item.head} {{", *lines(item.items, inner, depth + 1)]
            following = items[k + 1] if k + 1 < len(items) else None
            closed = isinstance(following, Block) and following.head.startswith("} else")
            found += [] if closed else [f"{indent}}}"]
        elif k in declared:
            found.append(f"{indent}{declared[k]} = {item.value};")
        else:
            found.append(f"{indent}{item.text}")

    return found


def _is_structure(declaration):
    return declaration.split()[0] not in ("double", "int32_t", "bool", "const")


def _can_go_into(block, name):
    """Whether a variable that only one block knows can be declared in it: no value of it lives from one turn
    of a loop to the next.
    """
    if name in words(block.head):
        return False

    if not block.head.startswith(("for", "while")):
        return True

    return _begins_anew(block.items, name)


def _begins_anew(items, name):
    """Whether the first thing said of a variable is that it is given a value."""
    for item in items:
        if name not in _mentions(item):
            continue

        if isinstance(item, Line):
            return item.name == name and item.sign == "=" and name not in words(item.value)

        others = [other for other in items if other is not item and name in _mentions(other)]
        return not others and name not in words(item.head) and _begins_anew(item.items, name)

    return True
