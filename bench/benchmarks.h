// The groups of benchmarks. Each benchmark checks the result of the last frame that it timed, and is reported as an
// error where that is wrong.
#pragma once

namespace facetsort::bench {

// sort/METHOD/MESH: facet ids. sort_indices/METHOD/MESH: the reordered index buffer. sort_indices_culled/METHOD/MESH:
// without facets seen from behind. set_positions/METHOD/MESH: new positions for all vertices.
void register_sort_benchmarks();
// floor/MESH: what memory alone costs.
void register_floor_benchmarks();
// peer_*/MESH: sorts that anyone can write or link, keys and index buffer included.
void register_peer_benchmarks();
// exact/MESH, exact_tree/MESH, presorted/MESH: the exact orders, cuts included.
void register_exact_benchmarks();
// open_fsort, write_fsort: presorted meshes as files; read_bytes: copying such a file's bytes alone.
void register_presorted_file_benchmarks();
// read_presorted/MESH, read_presorted_orbit_DEGREES/MESH: index buffers read from presorted meshes, by eyes that jump and
// eyes that move a little; read_presorted_facet_sort/MESH: the meshes sorted by depth.
void register_presorted_benchmarks();
// vtk_depth_sort/MESH: VTK's own, where the build found VTK.
void register_vtk_benchmarks();
// draw/FORMAT/MESH: the blend target at 1024 x 1024, facets already in order. STRATEGY/FORMAT/MESH: the strategies that
// need no order.
void register_draw_benchmarks();
// llvmpipe_draw/FORMAT/MESH: the same by Mesa's software OpenGL driver, where the build found OSMesa.
void register_llvmpipe_benchmarks();
// collect_fragments/MESH: per-pixel lists at 512 x 512.
void register_fragment_benchmarks();
// index_buffers/MESH, index_buffers_culled/MESH: ten index buffers, and what they err.
void register_index_buffers_benchmarks();
// scene_50_knots/side_SIDE/METHOD: 50 knots of 10,000 facets, scattered over a cube, sorted together; _as_found: without
// bringing the triangles of an object together.
// plan_50_opaque_knots: the plan of such a scene in which nothing is blended.
void register_scene_benchmarks();

}  // namespace facetsort::bench
