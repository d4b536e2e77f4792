#!/usr/bin/env python3
"""Judges `auto`: does it stay within its budget in every view, and how much longer do its frames take than those of the
fastest strategy that does, found by trying all of them? Needs the built program.

  bench/judge_plan.py [--size N] [--repeats N] [--rounds N] MESH...
  bench/judge_plan.py --size 512 meshes/*.ply

A line a mesh and budget, 0 and 0.1 % of a view's covered pixels: four views around the mesh, each frame order and blend
from a new eye, the median of the repeats, of that the least of the rounds, and the mean of the views. What is done
once is told apart. Exits with 1 where a budget is not met or a frame takes more than 1.25 times as long.
"""
import argparse
import json
import pathlib
import subprocess
import sys
import tempfile

BUDGETS = {"auto": 0, "auto:0.001": 0.001}
# All that need no number, but for additive, which is another picture; and the others at sensible ones, but for
# presorted_buffers, which takes minutes to make.
STRATEGIES = """unsorted double_sided separate_culling_pass depth_prepass depth_write premultiplied_over
facet_sort:centroid_distance facet_sort:centroid_depth facet_sort:bounds_centre facet_sort:first_vertex
facet_sort:nearest_vertex facet_sort:farthest_vertex facet_sort:exact facet_sort:exact_tree facet_sort:presorted depth_peeling
dual_depth_peeling weighted_blended moment_based:4 moment_based:6 multi_layer:4 multi_layer:8 multi_layer:16
multi_layer:32 multi_layer:64 stochastic:16 reference""".split()
MOST = 1.25


def compare(program, mesh, size, repeats):
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([program, "compare", mesh, "--strategies", ",".join(STRATEGIES + list(BUDGETS)), "--views", "4",
                        "--size", str(size), "--repeats", str(repeats), "--out", folder + "/report"],
                       check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        return json.loads(pathlib.Path(folder, "report", "results.json").read_text())["rows"]


def frame_ms(rows):
    times = {}
    for row in rows:
        times.setdefault(row["view"], []).append(row["order_ms"] + row["blend_ms"])
    return sum(min(of_view) for of_view in times.values()) / len(times)


def worst_rate(rows):
    return max(1 if row["wrong_rate"] is None else row["wrong_rate"] for row in rows)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--size", type=int, default=256)
    parser.add_argument("--repeats", type=int, default=9)
    parser.add_argument("--rounds", type=int, default=2)
    parser.add_argument("meshes", nargs="+", metavar="MESH")
    options = parser.parse_args()
    program = pathlib.Path(__file__).resolve().parent.parent / "build/release/apps/facetsort/facetsort"
    failed = False
    print(f"{'mesh':18} {'budget':>7} {'worst wrong':>11} {'auto ms':>9} {'fastest ms':>10} {'ratio':>6} "
          f"{'prepared ms':>11}  fastest that meets it")
    for mesh in options.meshes:
        rows = [row for _ in range(options.rounds) for row in compare(program, mesh, options.size, options.repeats)]
        by_strategy = {}
        for row in rows:
            by_strategy.setdefault(row["strategy"], []).append(row)
        for name, budget in BUDGETS.items():
            auto = by_strategy[name]
            meeting = {s: r for s, r in by_strategy.items() if s not in BUDGETS and worst_rate(r) <= budget}
            fastest = min(meeting, key=lambda s: frame_ms(meeting[s]))
            ratio = frame_ms(auto) / frame_ms(meeting[fastest])
            is_met = worst_rate(auto) <= budget
            failed = failed or not is_met or ratio > MOST
            print(f"{pathlib.Path(mesh).stem:18} {100 * budget:6g}% {100 * worst_rate(auto):10.4f}% "
                  f"{frame_ms(auto):9.2f} {frame_ms(meeting[fastest]):10.2f} {ratio:6.2f} {auto[0]['prepare_ms']:11.0f}  "
                  f"{fastest}{'' if is_met else '  BUDGET NOT MET'}", flush=True)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
