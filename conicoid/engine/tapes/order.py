"""The order in which a tape is played: its tests as early as they can be, and nothing that is not needed.

A body for which a tape does not hold then costs little. Tests stay in their order, and no operation comes before a test
that it came after, so what a test guards stays guarded.
"""

from __future__ import annotations

from ...shapes.recorder import Tape

Operation = tuple[str, int, int, int, int]

_TESTS = ("sign", "plain sign", "turn")
_OF_WIDES = ("add", "subtract", "multiply", "divide", "root", "negate", "size", "round", "sign", "write wide")
_OF_NOTHING = ("constant", "given", "input", "number")
_ONE_OPERAND = (
    "root", "negate", "size", "round", "widen", "sine and cosine", "plain root", "plain negate", "plain size", "above",
    "power", "unit sign", "sign", "plain sign", "turn", "write wide",
)  # fmt: skip
_WRITE_WIDES = ("widen", "constant", "given", "add", "subtract", "multiply", "divide", "root", "negate", "size")
WIDE, PLAIN = "wide", "plain"
Register = tuple[str, int]


def in_order(tape: Tape) -> list[Operation]:
    """The operations of a tape, in the order in which they are played."""
    code = tape.code
    maker: dict[Register, int] = {}
    for place, operation in enumerate(code):
        maker.update((register, place) for register in _written(operation))
    order: list[int] = []
    done = [False] * len(code)

    def take(place: int) -> None:
        """An operation, after what it needs, in the order of the tape."""
        needed, pending = {place}, [place]
        while pending:
            for register in _read(code[pending.pop()]):
                before = maker[register]
                if not done[before] and before not in needed:
                    needed.add(before)
                    pending.append(before)
        for each in sorted(needed):
            done[each] = True
            order.append(each)

    for place, operation in enumerate(code):
        if operation[0] in _TESTS and not done[place]:
            take(place)
    for place, operation in enumerate(code):
        if operation[0] == "write wide":
            take(place)
    for register in tape.written:
        place = maker[PLAIN, register]
        if not done[place]:
            take(place)
    return [code[place] for place in order]


def _written(operation: Operation) -> list[Register]:
    """The registers that an operation writes."""
    which, register = operation[:2]
    if which in _TESTS or which == "write wide":
        return []
    if which == "sine and cosine":
        return [(WIDE, register), (WIDE, register + 1)]
    return [(WIDE if which in _WRITE_WIDES else PLAIN, register)]


def _read(operation: Operation) -> list[Register]:
    """The registers that an operation reads."""
    which, _, a, b, c = operation
    if which in _OF_NOTHING:
        return []
    kind = WIDE if which in _OF_WIDES else PLAIN
    if which in _ONE_OPERAND:
        return [(kind, a)]
    return [(kind, a), (kind, b), (kind, c)] if which == "several" else [(kind, a), (kind, b)]
