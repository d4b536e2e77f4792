#!/usr/bin/env python3
"""Reads a .fsort file as lib/facetsort/order/FSORT.md describes it, with Python's standard library and nothing of
facetsort: that the document suffices is what this shows.

    read_fsort.py tree FILE X Y Z W       prints the tree's triangles, back to front for the eye, a line each
    read_fsort.py buffer FILE X Y Z W     prints the facets of the index buffer for the eye, a line each

W is 1 where X Y Z is a point, 0 where it is the direction towards the viewer.
"""
import struct
import sys
import zlib
from fractions import Fraction

FORMATS = {
    "POSI": "3f", "FACE": "3I", "FCOL": "4f", "VCOL": "4f", "MVER": "I3f", "MPOS": "3f", "NODE": "6I", "PIEC": "3I",
    "TRIA": "3I", "CUTS": "Ii", "PLAN": "5I", "BUFS": "2I2d", "BFAC": "I", "BDIR": "3f", "BOFD": "I",
}


def read_sections(data):
    magic, version, checksum, file_size, section_count, _ = struct.unpack_from("<8sIIQII", data)
    if magic != b"\x89FSORT\r\n" or version != 1:
        sys.exit("is no .fsort file of version 1")
    if file_size != len(data) or checksum != zlib.crc32(data[16:]):
        sys.exit("is damaged")
    sections = {name: [] for name in FORMATS}
    for i in range(section_count):
        name, flags, offset, size, count = struct.unpack_from("<4sIQQQ", data, 32 + 32 * i)
        name = name.decode("ascii")
        if name in FORMATS:
            record = struct.Struct("<" + FORMATS[name])
            if offset + size > len(data) or size != count * record.size:
                sys.exit("section " + name + " does not fit")
            sections[name] = list(record.iter_unpack(data[offset:offset + size]))
        elif flags & 1:
            sys.exit("needs section " + name)
    return sections


def cross(u, v):
    return [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]


def dot(u, v):
    return sum(x * y for x, y in zip(u, v))


def is_seen_from_front(positions, plane, eye):
    a, b, c = ([Fraction(x) for x in positions[vertex]] for vertex in plane)
    normal = cross([y - x for x, y in zip(a, b)], [y - x for x, y in zip(a, c)])
    return dot(normal, [e - x * eye[3] for e, x in zip(eye, a)]) >= 0


def running_sums(counts, first=0):
    sums = [first]
    for count in counts:
        sums.append(sums[-1] + count)
    return sums


def triangles_of_tree(sections, eye):
    eye = [Fraction(x) for x in eye]
    nodes, triangles = sections["NODE"], sections["TRIA"]
    first_triangle = running_sums(piece[1] for piece in sections["PIEC"])
    pieces_in_nodes = sum(node[3] for node in nodes)
    first_piece = running_sums((node[3] for node in nodes), len(sections["PIEC"]) - pieces_in_nodes)
    first = [first_triangle[piece] for piece in first_piece]

    ordered = triangles[:first[0]] + [None] * (len(triangles) - first[0])
    place = [first[0]] * (len(nodes) + 1)
    for i, (a, b, c, _, front_nodes, back_nodes) in enumerate(nodes):
        front, back = i + 1, i + 1 + front_nodes
        from_front = is_seen_from_front(sections["POSI"], (a, b, c), eye)
        in_front, behind = first[back] - first[front], first[back + back_nodes] - first[back]
        own = triangles[first[i]:first[front]]
        own_place = place[i] + (behind if from_front else in_front)
        ordered[own_place:own_place + len(own)] = own
        far_place, near_place = place[i], own_place + len(own)
        if front_nodes:
            place[front] = near_place if from_front else far_place
        if back_nodes:
            place[back] = far_place if from_front else near_place
    return ordered


def facets_of_buffer(sections, eye):
    corners = [sections["POSI"][vertex] for facet in sections["FACE"] for vertex in facet]
    centre = [(min(axis) + max(axis)) / 2 for axis in zip(*corners)]
    towards_eye = [e - x * eye[3] for e, x in zip(eye, centre)]
    directions = sections["BDIR"]
    nearest = max(range(len(directions)), key=lambda i: dot(directions[i], towards_eye))
    buffer, facet_count = sections["BOFD"][nearest][0], len(sections["FACE"])
    return sections["BFAC"][buffer * facet_count:(buffer + 1) * facet_count]


def main():
    if len(sys.argv) != 7 or sys.argv[1] not in ("tree", "buffer"):
        sys.exit(__doc__)
    with open(sys.argv[2], "rb") as file:
        sections = read_sections(file.read())
    eye = [float(word) for word in sys.argv[3:]]
    order = triangles_of_tree if sys.argv[1] == "tree" else facets_of_buffer
    for record in order(sections, eye):
        print(*record)


if __name__ == "__main__":
    main()
