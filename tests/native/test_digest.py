"""Every kind of answer has the digest that it has on all processors, systems and ways of compiling."""

import json
from pathlib import Path

from benchmarks.digest import Numbers, digests

DIGESTS = Path(__file__).with_name("digests.json")


def test_answers_are_those_of_all_platforms():
    assert digests() == json.loads(DIGESTS.read_text(encoding="utf-8"))


def test_the_numbers_are_marsaglias():
    # xorshift64 with (13, 7, 17), by hand from 1: 1 ^ 1 << 13 is 0x2001, ^ >> 7 is 0x2041, and ^ << 17 is 0x40822041.
    numbers = Numbers(1)
    numbers.next()
    assert numbers.state == 0x40822041
