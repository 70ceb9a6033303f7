"""Elements of an XML file: their numbers and texts, and what is wrong with them, by line."""

import math
from collections import Counter
from contextlib import contextmanager

from lxml import etree

from ..errors import Problem, SceneError, did_you_mean, quoted, show
from ..fields import LARGEST


class Reading:
    """A file that is being read.

    problems : what is wrong in it, `Problem`s in the order found.
    left_out : Counter of what is in it and not taken over, by words.
    """

    def __init__(self):
        self.problems = []
        self.left_out = Counter()

    def wrong(self, element, text, key=None):
        """Notes what is wrong with an element, or with its attribute `key`."""
        self.problems.append(Problem((), f"{place(element, key)}: {text}"))

    @contextmanager
    def finished(self, file):
        """At the end of the block all that was wrong is raised as SceneError."""
        yield
        if self.problems:
            raise SceneError(self.problems, file=file)

    def text(self, element, key):
        """An attribute that must be there and say something, or None with a problem."""
        value = element.get(key)

        if value is None:
            near = did_you_mean(key, element.attrib)
            self.wrong(element, f'{quoted(key)} is missing; it needs {key}="...".{near}')
        elif not value.strip():
            self.wrong(element, "is empty", key)
        else:
            return value.strip()

        return None

    def number(self, element, key, default=None, infinite=False):
        """An attribute as a number, `default` where it is not there; None default: it must be. 0 with a problem."""
        numbers = self.numbers(element, key, 1, None if default is None else (default,), infinite)
        return numbers[0]

    def numbers(self, element, key, count, default=None, infinite=False):
        """An attribute as `count` numbers (a tuple), as `number`."""
        text = element.get(key)

        if text is None and default is not None:
            return default

        if text is None:
            self.text(element, key)
            return (0.0,) * count

        words = text.split()

        try:
            values = tuple(_float(word, infinite) for word in words)
        except ValueError as error:
            self.wrong(element, str(error), key)
            return (0.0,) * count

        if len(values) != count:
            what = "a number" if count == 1 else f"{count} numbers with blanks between"
            self.wrong(element, f"needs {what}, found {show(text)}", key)
            return (0.0,) * count

        return values

    def child(self, element, tag, needed=False):
        """The child of that tag, or None; the first where there are more, which is a problem."""
        found = element.findall(tag)

        if len(found) > 1:
            self.wrong(found[1], f"the second <{tag}> of one {_name(element)}; keep one of them")
        if needed and not found:
            tags = [child.tag for child in element if isinstance(child.tag, str)]
            self.wrong(element, f"<{tag}> is missing.{did_you_mean(tag, tags)}")

        return found[0] if found else None


def _float(word, infinite):
    """A number as XML files have it."""
    try:
        value = float(word)
    except ValueError:
        hint = "; decimals stand after a point" if "," in word else ""
        raise ValueError(f"needs a number, found {show(word)}{hint}") from None

    if "_" in word:
        raise ValueError(f"needs a number, found {show(word)}")
    if infinite and math.isinf(value):
        return value
    if not abs(value) <= LARGEST:
        raise ValueError(f"needs a finite number, at most 1e30; found {show(word)}")
    return value


def parsed(data, file):
    """The root element of an XML file's bytes. Nothing outside the file is fetched. Raises SceneError with the line."""
    parser = etree.XMLParser(resolve_entities=False, no_network=True, load_dtd=False, huge_tree=False)

    try:
        root = etree.fromstring(data, parser)
    except etree.XMLSyntaxError as error:
        line = error.position[0]
        shown = data.decode("utf-8", "replace").splitlines()[line - 1 : line]
        what = str(error.msg).partition(", line")[0]
        text = f"line {line}: not valid XML: {what}" + (f" in {show(shown[0].strip())}" if shown else "")
        raise SceneError([Problem((), text)], file=file) from None

    return root


def _name(element):
    """An element in words, with its name."""
    name = element.get("name")
    return f"<{element.tag} name={quoted(name)}>" if name else f"<{element.tag}>"


def place(element, key=None):
    """Where an element is: line, the named element that it belongs to, itself, an attribute of it."""
    chain = [element, *element.iterancestors()]
    named = next((k for k, item in enumerate(chain) if item.get("name") and item.getparent() is not None), 0)
    words = [_name(item) for item in reversed(chain[: named + 1])]
    return " ".join([f"line {element.sourceline}:", *words, *([key] if key else [])])
