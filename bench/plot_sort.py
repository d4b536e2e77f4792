#!/usr/bin/env python3
"""bench/plot_sort.py RESULTS.json... OUT: a table OUT.md and a plot OUT.png (by gnuplot) of facets a second.

The first RESULTS.json is --benchmark_out of facetsort-bench; another may be what bench/peers/babylon.js writes. Medians
are taken where there are repetitions."""
import json
import re
import subprocess
import sys

CONTENDERS = [
    ("floor, 2 threads", r"floor/(?P<mesh>\w+)/threads:2"),
    ("facetsort, 2 threads", r"sort_indices/centroid_distance/(?P<mesh>\w+)/threads:2"),
    ("floor, 1 thread", r"floor/(?P<mesh>\w+)/threads:1"),
    ("facetsort, 1 thread", r"sort_indices/centroid_distance/(?P<mesh>\w+)/threads:1"),
    ("whole keys, 1 thread", r"sort_indices_whole_keys/centroid_distance/(?P<mesh>\w+)/threads:1"),
    ("facetsort culled, 2 threads", r"sort_indices_culled/centroid_distance/(?P<mesh>\w+)/threads:2"),
    ("facetsort culled, 1 thread", r"sort_indices_culled/centroid_distance/(?P<mesh>\w+)/threads:1"),
    ("radix sort of 30 lines", r"peer_radix_sort/(?P<mesh>\w+)"),
    ("VQSort of pairs", r"peer_vqsort/(?P<mesh>\w+)"),
    ("std::sort of pairs", r"peer_std_sort/(?P<mesh>\w+)"),
    ("vtkDepthSortPolyData", r"vtk_depth_sort/(?P<mesh>\w+)"),
    ("Babylon.js", r"peer_babylon/(?P<mesh>\w+)"),
]


# Of the meshes that a contender is drawn at where it has no knots.
FACETS = {"bunny_70k": 69666, "dragon_871k": 871414}


def read(paths):
    """Facets a second by contender and mesh, and the first run's context."""
    results = []
    for path in paths:
        with open(path) as file:
            results.append(json.load(file))
    speeds = {name: {} for name, _ in CONTENDERS}
    for run in [run for result in results for run in result["benchmarks"]]:
        if run.get("error_occurred"):
            sys.exit(f"{run['name']}: {run['error_message']}")
        if run.get("aggregate_name", "median") != "median":
            continue
        if run["run_type"] == "iteration" and run.get("repetitions", 1) > 1:
            continue
        for name, pattern in CONTENDERS:
            match = re.fullmatch(pattern + "/real_time", run["run_name"])
            if match:
                speeds[name][match["mesh"]] = run["items_per_second"]
    return speeds, results[0]["context"]


def table(speeds, context):
    fastest, floor = speeds["facetsort, 2 threads"], speeds["floor, 2 threads"]
    meshes = sorted(fastest, key=lambda mesh: (re.sub(r"\d", "", mesh), int(re.search(r"\d+", mesh)[0])))
    names = [name for name, _ in CONTENDERS]
    lines = ["Millions of facets a second, medians; the second column is the floor over facetsort, both with 2 threads.",
             "VTK and Babylon.js get bunny_70k and dragon_871k as their files have them: compare with the rows `_as_read`.",
             f"{context['date'][:10]}; {context['machine']}. Made by", "", "```",
             "FACETSORT_MESH_PATH=FOLDER " + context["command"],
             "node bench/peers/babylon.js BUILD/bench/facetsort-bench FOLDER/bunny_70k.ply FOLDER/dragon_871k.ply", "```",
             "",
             "| | ratio | " + " | ".join(names) + " |", "|---" * (len(names) + 2) + "|"]
    for mesh in meshes:
        ratio = f"{floor[mesh] / fastest[mesh]:.2f}" if mesh in floor else ""
        cells = [f"{speeds[name][mesh] / 1e6:.3g}" if mesh in speeds[name] else "" for name in names]
        lines.append(f"| {mesh} | {ratio} | " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"


def plot(speeds, out):
    script = [f"set terminal pngcairo size 1100,700; set output '{out}'", "set logscale xy; set key outside; set grid",
              "set xlabel 'facets (knots in spatial order; Babylon.js: bunny and dragon)'; set ylabel 'million facets a second'"]
    names = []
    for index, (name, of) in enumerate(speeds.items()):
        points = sorted((int(mesh[5:]), speed) for mesh, speed in of.items() if re.fullmatch(r"knot_\d+", mesh))
        points = points or sorted((FACETS[mesh], speed) for mesh, speed in of.items() if mesh in FACETS)
        if points:
            script += [f"$data{index} << end"] + [f"{facets} {speed / 1e6}" for facets, speed in points] + ["end"]
            names.append(f"$data{index} with linespoints title '{name}'")
    script.append("plot " + ", ".join(names))
    subprocess.run(["gnuplot"], input="\n".join(script), text=True, check=True)


def main():
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    *paths, out = sys.argv[1:]
    speeds, context = read(paths)
    with open(out + ".md", "w") as file:
        file.write(table(speeds, context))
    plot(speeds, out + ".png")


if __name__ == "__main__":
    main()
