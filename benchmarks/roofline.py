"""The cost of a ray by counts: operations and bytes, and the share of the processor's peak.

    python benchmarks/roofline.py [most balls]

The kernels are compiled once more, in a process of their own, with counters in front of what they ask of
boxes, balls and lanes. What one such question takes in operations stands in the machine code. Times are of the
processor, of all threads together: nanoseconds a ray on one core.
"""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import time
from typing import Any

import numpy as np
from comparison.harness import machine
from comparison.scenes import balls, camera_rays, random_rays
from machine import copy_bandwidth, fused_peak, latency, least

import conicoid as co

NODE, LEAF, BALL, GROUP, LANES, STREAM_NODE, STREAM_LEAF, STREAM_BALL = range(8)
NAMES = (
    "eight boxes asked by a beam or a ray, or a box by eight beams", "leaves asked by a beam",
    "balls asked by 64 lanes",
    "balls asked by 8 lanes", "groups of 8 lanes that met a ball's sides", "rays at nodes, in streams",
    "leaves asked by a ray", "balls met by a ray",
)  # fmt: skip
WIDTH = 1024


def rays_of(kind: str) -> co.Rays:
    return co.Rays(*(camera_rays(WIDTH) if kind == "camera" else random_rays(WIDTH * WIDTH)))


def adder(counts: np.ndarray) -> Any:
    """add(which, number), for compiled functions: counts[which] += number."""
    from llvmlite import ir
    from numba import types
    from numba.extending import intrinsic

    @intrinsic
    def add(context, which, number):
        def code(context, builder, signature, arguments):
            whole = ir.IntType(64)
            place = builder.add(whole(counts.ctypes.data), builder.mul(arguments[0], whole(8)))
            pointer = builder.inttoptr(place, whole.as_pointer())
            builder.store(builder.add(builder.load(pointer), arguments[1]), pointer)
            return context.get_dummy_value()

        return types.void(types.int64, types.int64), code

    return add


def count_tiles(add: Any) -> None:
    """Put counters in front of what tiles ask, and what packets ask of what their tile sees."""
    from conicoid._jit.decorators import inline
    from conicoid.kernels.packet import frontier, traversal as packet_first

    items_met, put_groups, group_in_ball = packet_first.hit_items, packet_first.put_groups, packet_first.group_in_ball
    put_children, put_balls = frontier.put_children, frontier.put_balls

    @inline
    def counted_items(items, at, beam, start):
        add(NODE, 1)
        return items_met(items, at, beam, start)

    @inline
    def counted_children(boxes, at, codes, first, number, beam, start, found, t, end):
        add(NODE, 1)
        return put_children(boxes, at, codes, first, number, beam, start, found, t, end)

    @inline
    def counted_groups(items, item, number, lanes, beams, pairs, end):
        add(NODE, 1)
        return put_groups(items, item, number, lanes, beams, pairs, end)

    @inline
    def counted_balls(balls, at, count, leaf, beam, start, items, end):
        add(LEAF, 1)
        return put_balls(balls, at, count, leaf, beam, start, items, end)

    @inline
    def counted_group(lanes, group, x, y, z, r):
        add(GROUP, 1)
        return group_in_ball(lanes, group, x, y, z, r)

    packet_first.hit_items = frontier.hit_items = counted_items
    packet_first.put_groups, packet_first.group_in_ball = counted_groups, counted_group
    frontier.put_children, frontier.put_balls = counted_children, counted_balls


def count_packets(add: Any) -> None:
    """Put counters in front of the box tests of packets and single rays, and of the tests of a packet's lanes."""
    from conicoid._jit.decorators import inline
    from conicoid.kernels.bvh import walk
    from conicoid.kernels.packet import packet, traversal as packet_first

    boxes_met, balls_in_beam = walk.hit_boxes, packet_first.balls_in_beam
    lanes_in_ball, ball_lanes = packet.lanes_in_ball_from_one, packet.ball_lanes  # camera rays share their origin

    @inline
    def counted_boxes(floats, at, beam, start, near):
        add(NODE, 1)
        return boxes_met(floats, at, beam, start, near)

    @inline
    def counted_leaf(floats, at, stride, count, beam, start, near):
        add(LEAF, 1)
        return balls_in_beam(floats, at, stride, count, beam, start, near)

    @inline
    def counted_ball(lanes, x, y, z, r):
        add(BALL, 1)
        return lanes_in_ball(lanes, x, y, z, r)

    @inline
    def counted_lanes(lanes, sphere, surface, entry, body, first, last):
        add(LANES, (last - first) >> 3)
        ball_lanes(lanes, sphere, surface, entry, body, first, last)

    walk.hit_boxes, packet_first.balls_in_beam = counted_boxes, counted_leaf
    packet.lanes_in_ball_from_one, packet.ball_lanes = counted_ball, counted_lanes


def count_streams(add: Any) -> None:
    """Put counters in front of what streams and single rays ask."""
    from conicoid._jit.decorators import inline
    from conicoid.kernels import first_hits as kernels, stream

    put_on_lists, rays_in_balls, balls_met = stream.put_on_lists, stream.rays_in_balls, stream.hit_balls
    meet, put_pair = stream.intersect_item, stream.put_pair

    @inline
    def counted_list(boxes, at, octant, rays, lists, begin, count, room, counts):
        add(STREAM_NODE, count)
        put_on_lists(boxes, at, octant, rays, lists, begin, count, room, counts)

    @inline
    def counted_eight(balls, at, size, rays, more, lists, begin, left, asked):
        add(STREAM_LEAF, min(left, 8))
        return rays_in_balls(balls, at, size, rays, more, lists, begin, left, asked)

    @inline
    def counted_balls(floats, at, stride, count, ray, inverse, last):
        add(STREAM_LEAF, 1)
        return balls_met(floats, at, stride, count, ray, inverse, last)

    @inline
    def counted_pair(pairs, at, ray, geometry, leaf, size, place):
        add(STREAM_BALL, 1)
        put_pair(pairs, at, ray, geometry, leaf, size, place)

    @inline
    def counted_meet(geometry, scratch, item, sphere, ray, inverse, best):
        add(STREAM_BALL, 1)
        return meet(geometry, scratch, item, sphere, ray, inverse, best)

    stream.put_on_lists, stream.rays_in_balls = counted_list, counted_eight
    stream.hit_balls = kernels.hit_balls = counted_balls
    stream.intersect_item = kernels.intersect_item = counted_meet
    stream.put_pair = counted_pair


def count_all(sizes: list[int]) -> dict[str, list[float]]:
    """Questions a ray, by kind of rays and number of balls."""
    counts = np.zeros(len(NAMES), np.int64)
    add = adder(counts)
    for count in (count_tiles, count_packets, count_streams):  # before anything is compiled, on one thread
        count(add)
    found = {}
    for size in sizes:
        scene = co.Scene(balls(size).shapes())
        for kind in ("camera", "random"):
            rays = rays_of(kind)
            counts[:] = 0
            scene.first_hit(rays)
            found[f"{kind} {size}"] = (counts / WIDTH**2).tolist()
    return found


def operations(code: str) -> int:
    """Operations on doubles in machine code without loops; a fused multiply-add is two."""
    lanes = {"zmm": 8, "ymm": 4, "xmm": 2}
    total = 0
    for line in code.splitlines():
        found = re.match(r"\s+v(fn?m|add|sub|mul|div|sqrt|min|max)\w*?(pd|sd)\s.*?(?:%?([xyz]mm))?\d*$", line)
        if found:
            width = 1 if found[2] == "sd" else lanes[found[3] or "xmm"]
            total += width * (2 if found[1].startswith("f") else 1)
    return total


def costs() -> dict[int, float]:
    """Operations of each question, out of the code made for this machine."""
    from numba import njit

    from conicoid.kernels import stream
    from conicoid.kernels.bvh import walk
    from conicoid.kernels.packet import packet, traversal as packet_first
    from conicoid.kernels.ray import Ray
    from conicoid.kernels.surface.quadric import SphereRecord

    boxes_met, balls_in_beam = walk.hit_boxes, packet_first.balls_in_beam
    lanes_in_ball, group_in_ball = packet.lanes_in_ball_from_one, packet_first.group_in_ball
    ball_lanes, put_on_lists, balls_met = packet.ball_lanes, stream.put_on_lists, stream.hit_balls
    questions: dict[int, tuple[Any, float]] = {
        NODE: (lambda f, r, n, c, k: boxes_met(f, k, r, 0, n), 1),
        LEAF: (lambda f, r, n, c, k: balls_in_beam(f, k, 8, 8, r, 0, n), 1),
        BALL: (lambda f, r, n, c, k: lanes_in_ball(r, f[0], f[1], f[2], f[3]), 1),
        GROUP: (lambda f, r, n, c, k: group_in_ball(r, 0, f[0], f[1], f[2], f[3]), 1),
        # Written twice: for lanes with one origin, and for others
        LANES: (lambda f, r, n, c, k: ball_lanes(r, SphereRecord(f[0], f[1], f[2], f[3]), 0, 0, 0, 0, 8), 2),
        STREAM_NODE: (lambda f, r, n, c, k: put_on_lists(f, 0, k, r, n, 0, 8, 64, c), 8),
        STREAM_LEAF: (
            lambda f, r, n, c, k: balls_met(
                f, k, 8, 8, Ray(f[0], f[1], f[2], f[3], f[4], f[5], 0.0, 1.0, k), f[6], 1.0
            ),
            1,
        ),
    }
    result = {}
    for which, (question, share) in questions.items():
        kinds = "(float64[::1], float64[::1], {}[::1], int32[::1], int64)".format(
            "int64" if which == STREAM_NODE else "float64"
        )
        code = njit(kinds, error_model="numpy", no_cpython_wrapper=True, no_cfunc_wrapper=True)(question)
        result[which] = operations(next(iter(code.inspect_asm().values()))) / share
    result[STREAM_BALL] = result[LANES] / 8  # the same formula, of one lane
    return result


def main() -> None:
    most = int(float(sys.argv[1])) if len(sys.argv) > 1 else 1_000_000
    sizes = [size for size in (1000, 100_000, 1_000_000) if size <= most]
    environment = os.environ | {"CONICOID_THREADS": "1", "CONICOID_JIT": "own"}
    command = [sys.executable, __file__, "count", *map(str, sizes)]
    counted = json.loads(subprocess.run(command, env=environment, stdout=subprocess.PIPE, check=True).stdout)
    peak, each = fused_peak(), costs()
    print(f"one core: {peak / 1e9:.0f} Gflop/s; copies: {copy_bandwidth() / 1e9:.0f} GB/s read and written, all cores")
    for size in (1 << 15, 1 << 19, 1 << 23, 1 << 28):
        print(f"an address in {size / 2**20:g} MiB is read in {1e9 * latency(size):.1f} ns")
    for which, operations_of_one in each.items():
        print(f"{operations_of_one:.0f} operations: {NAMES[which]}")
    print("| rays | balls | " + " | ".join(NAMES) + " | operations | ns | Gflop/s | share of the peak |")
    for name, counts in counted.items():
        kind, size = name.split()
        scene, rays = co.Scene(balls(int(size)).shapes()), rays_of(kind)
        scene.first_hit(rays)
        seconds = least(lambda scene=scene, rays=rays: scene.first_hit(rays), time.process_time, 9) / WIDTH**2
        total = sum(counts[which] * cost for which, cost in each.items())
        figures = [f"{number:.3g}" for number in counts]
        print(
            f"| {kind} | {int(size):,} | {' | '.join(figures)} | {total:.0f} | {1e9 * seconds:.1f} "
            f"| {total / seconds / 1e9:.1f} | {100 * total / seconds / peak:.0f} % |",
            flush=True,
        )
    print("\n".join(machine([])))


if __name__ == "__main__":
    if sys.argv[1:2] == ["count"]:
        print(json.dumps(count_all([int(size) for size in sys.argv[2:]])))
    else:
        main()
