"""Schedule a tape: tests as early as possible, and nothing that is not needed.

A body for which a tape is not valid then costs little. Tests stay in their order, and no operation moves ahead of a
test that preceded it, so what a test guards stays guarded.
"""

from __future__ import annotations

from ...numerics.tracing import Operation, Tape

_TESTS = ("sign", "plain sign", "turn")
_WIDE, _PLAIN = 0, 1
_NONE = ("constant", "given", "input", "number")
_OF_A_WIDE = ("root", "negate", "size", "round", "sign", "write wide")
_OF_WIDES = ("add", "subtract", "multiply", "divide")
_OF_A_PLAIN = (
    "widen", "sine and cosine", "plain root", "plain negate", "plain size", "above", "power", "unit sign", "plain sign",
    "turn",
)  # fmt: skip
_READS = {
    **dict.fromkeys(_NONE, (_PLAIN, 0)),
    **dict.fromkeys(_OF_A_WIDE, (_WIDE, 1)),
    **dict.fromkeys(_OF_WIDES, (_WIDE, 2)),
    **dict.fromkeys(_OF_A_PLAIN, (_PLAIN, 1)),
    "several": (_PLAIN, 3),
}
"""The kind of an operation's operands, and their count; other operations read two plain ones."""


def schedule_tape(tape: Tape) -> list[Operation]:
    """Return the needed operations of a tape, in the order in which they are played."""
    code, makers = tape.code, (tape.wide_makers, tape.plain_makers)
    order: list[int] = []
    done = bytearray(len(code))

    def take(place: int) -> None:
        """Add an operation after all that it needs, in the order of the tape."""
        needed, done[place] = [place], 1
        for each in needed:  # grows in the loop
            operation = code[each]
            kind, count = _READS.get(operation[0], (_PLAIN, 2))
            for register in operation[2:][:count]:
                before = makers[kind][register]
                if not done[before]:
                    done[before] = 1
                    needed.append(before)
        needed.sort()
        order.extend(needed)

    for place, operation in enumerate(code):
        if operation[0] in _TESTS:
            take(place)
    for place, operation in enumerate(code):
        if operation[0] == "write wide":
            take(place)
    for register in tape.written:
        place = tape.plain_makers[register]
        if not done[place]:
            take(place)
    return [code[place] for place in order]
