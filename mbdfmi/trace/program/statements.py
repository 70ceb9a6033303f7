"""The statements of a kernel in C."""

import ast

from ..graph import Untraceable
from .expressions import UNKNOWN, Expressions, Text, plain
from .layout_c import Block, Line
from .shapes import ANY_INT, Array, Number


class Statements(Expressions):
    """Writes the statements of one kernel; what they make of variables is told to `function`."""

    def block(self, nodes) -> tuple[list, bool]:
        """(items, whether what comes after them is reached)."""
        found: list = []

        for node in nodes:
            items, goes_on = self._statement(node)
            found += items

            if not goes_on:
                return found, False

        return found, True

    def _statement(self, node):
        match node:
            case ast.Expr(value=ast.Constant()) | ast.Pass():
                return [], True
            case ast.Expr(value=value):
                found = self.expression(value)
                return [Line(f"{found.text};")] if found.acts else [], True
            case ast.Assign(targets=targets, value=value):
                return [item for target in targets for item in self._assign(target, value)], True
            case ast.AugAssign(target=target, op=op, value=value):
                return self._add_to(target, op, value), True
            case ast.If(test=test, body=body, orelse=other):
                return self._if(test, body, other)
            case ast.For(
                target=ast.Name(id=name), iter=ast.Call(func=ast.Name(id="range"), args=given), body=body
            ):
                return self._for(name, given, body)
            case ast.For(target=target, iter=ast.Tuple(elts=each), body=body) if not _jumps(body):
                return [
                    item for one in each for item in [*self._assign(target, one), *self.block(body)[0]]
                ], True
            case ast.While(test=test, body=body):
                return self._while(test, body)
            case ast.Break():
                return [Line("break;")], False
            case ast.Continue():
                return [Line("continue;")], False
            case ast.Return(value=value):
                return self._return(value), False

        raise Untraceable(f"{ast.unparse(node)} is not translated")

    # values

    def _assign(self, target, node):
        if isinstance(target, ast.Tuple):
            return self._assign_members(target.elts, node)

        return self._give(target, self.expression(node))

    def _give(self, target, found: Text):
        """A value given to a variable, or to a place of an array."""
        if found.shape is None:
            return []

        if isinstance(target, ast.Name):
            found = self._value(found)
            shape = self.function.learn(target.id, found.shape)
            found = self.coerced(found, shape)
            name = self.function.spelled(target.id)
            return [Line(f"{name} = {found.text};", name, found.text, "=", found.acts)]

        place = self._written(target)
        return [Line(f"{place.text} = {found.text};"), *self._behind(target)] if place.shape else []

    def _behind(self, target):
        """What is said of an array to come behind what is written to it."""
        shape = self.expression(target.value).shape
        name = shape.name if isinstance(shape, Array) else None
        return [Line(self.program.behind[name])] if name in self.program.behind else []

    def _written(self, target):
        """A place of an array that is written to."""
        assert isinstance(target, ast.Subscript), ast.unparse(target)
        owner = self.expression(target.value)
        place = self.expression(target.slice)

        if owner.shape is None or place.shape is None:
            return UNKNOWN

        if isinstance(target.value, ast.Name):
            self.function.writes_to(target.value.id)

        self.function.acts_now()
        return self.program.element(owner, place)

    def _assign_members(self, targets, node):
        if isinstance(node, ast.Tuple):
            given = [self._value(self.expression(each)) for each in node.elts]
            names = {name.id for target in targets for name in ast.walk(target) if isinstance(name, ast.Name)}
            used = {name.id for each in node.elts for name in ast.walk(each) if isinstance(name, ast.Name)}

            # one that is read after it is written would be another
            if names & used and all(each.shape is not None for each in given):
                return self._through_others(targets, given)

            return [
                item for target, each in zip(targets, given, strict=True) for item in self._give(target, each)
            ]

        found = self._value(self.expression(node))

        if found.shape is None:
            return []

        name = self.function.another(found.shape)
        items: list = [Line(f"{name} = {found.text};", name, found.text, "=", found.acts)]
        whole = Text(found.shape, name)

        for k, target in enumerate(targets):
            items += self._give(target, self._part(whole, k))

        return items

    def _through_others(self, targets, given):
        items: list = []
        kept = []

        for each in given:
            name = self.function.another(each.shape)
            items.append(Line(f"{name} = {each.text};", name, each.text, "=", each.acts))
            kept.append(Text(each.shape, name))

        return items + [
            item for target, each in zip(targets, kept, strict=True) for item in self._give(target, each)
        ]

    def _add_to(self, target, op, node):
        before = self.expression(ast.copy_location(_as_read(target), target))
        value = self.expression(node)

        if before.shape is None or value.shape is None:
            return []

        # as numbers are, a variable may be known only here: its text is its name
        result = self.binary(op, before, value)

        if isinstance(target, ast.Name):
            shape = self.function.learn(target.id, result.shape)
            name = self.function.spelled(target.id)
            result = self.coerced(self.binary(op, Text(shape, name), value), shape)
            if result.text == name and not value.acts:
                # 0 is added, which compilers warn of
                return []
            return [Line(f"{name} = {result.text};", name, result.text, "+=", value.acts)]

        place = self._written(target)
        sign = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/"}[type(op)]
        return [Line(f"{place.text} {sign}= {value.text};"), *self._behind(target)]

    def _return(self, node):
        if node is None:
            return [Line("return;")]

        found = self._value(self.expression(node))

        if found.shape is None:
            return []

        shape = self.function.learn_returned(found.shape)
        return [Line(f"return {self.coerced(found, shape).text};")]

    # branches and loops

    def _if(self, test, body, other):
        condition = self._truth(self.expression(test))

        if condition.shape is None:
            return [], True

        if condition.only is not None:
            return self.block(body if condition.only else other)

        # what holds always where something has been done for it
        first = [] if condition.shape.values == frozenset([False]) else None
        items, goes_on = (first, True) if first is not None else self.block(body)
        others, goes_on_otherwise = self.block(other)
        found = [Block(f"if ({condition.text})", items)]

        if others:
            found.append(Block("} else", others))

        return found, goes_on or goes_on_otherwise

    def _while(self, test, body):
        condition = self._truth(self.expression(test))

        if condition.shape is None or condition.only is False:
            return [], True

        items, _ = self.block(body)
        return [Block(f"while ({condition.text})", items)], True

    def _for(self, name, given, body):
        bounds = [self.expression(each) for each in given]

        if any(bound.shape is None for bound in bounds):
            return [], True

        first, last = (plain(0), bounds[0]) if len(bounds) == 1 else bounds[:2]
        step = bounds[2] if len(bounds) == 3 else plain(1)
        back = step.only is not None and step.only < 0

        if (
            first.only is not None
            and last.only is not None
            and not (first.only > last.only if back else first.only < last.only)
        ):
            return [], True

        self.function.learn(name, _turns(first, last, step), counts=True)
        items, _ = self.block(body)
        spelled = self.function.spelled(name)
        counter = spelled if self.function.counts_alone(name) else self.function.another(ANY_INT, True)
        end = last.text if last.only is not None else f"{counter}_end"
        begun = f"{counter} = {first.text}" + ("" if last.only is not None else f", {end} = {last.text}")
        onward = {1: f"{counter}++", -1: f"{counter}--"}.get(step.only, f"{counter} += {step.text}")
        head = f"for (int32_t {begun}; {counter} {'>' if back else '<'} {end}; {onward})"

        if counter != spelled:
            items = [Line(f"{spelled} = {counter};", spelled, counter), *items]

        return [Block(head, items)], True


def _jumps(body):
    """Whether a loop's body leaves it, or begins the next turn."""
    nodes = [node for statement in body for node in ast.walk(statement)]
    return any(isinstance(node, (ast.Break, ast.Continue, ast.Return)) for node in nodes)


def _turns(first, last, step):
    """What a counter may be."""
    if any(bound.only is None for bound in (first, last, step)):
        return ANY_INT

    values = range(first.only, last.only, step.only)
    return Number(ANY_INT.kind, frozenset(values) if len(values) <= 8 else None)


def _as_read(target):
    """A target as an expression."""
    if isinstance(target, ast.Name):
        return ast.Name(target.id, ast.Load())

    return ast.Subscript(target.value, target.slice, ast.Load())
