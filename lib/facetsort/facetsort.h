// The public headers, in pipeline order: mesh, facets, order, exact decisions, scene, blend, check, presort, plan,
// report.
#pragma once

// clang-format off: sorting would lose the pipeline order.
#include "facetsort/base/memory.h"
#include "facetsort/base/parallel.h"
#include "facetsort/base/status.h"
#include "facetsort/base/stopwatch.h"
#include "facetsort/base/file_bytes.h"
#include "facetsort/base/new_file.h"

#include "facetsort/mesh/material.h"
#include "facetsort/mesh/mesh_view.h"
#include "facetsort/mesh/mesh.h"
#include "facetsort/mesh/read.h"
#include "facetsort/mesh/inspect.h"
#include "facetsort/mesh/write.h"

#include "facetsort/facets/facets.h"
#include "facetsort/facets/pieces.h"

#include "facetsort/order/method.h"
#include "facetsort/order/key_sort.h"
#include "facetsort/order/sorter.h"
#include "facetsort/order/spatial_order.h"
#include "facetsort/order/presorted_data.h"
#include "facetsort/order/presorted_mesh.h"
#include "facetsort/order/presorted_reader.h"

#include "facetsort/exact/predicates.h"
#include "facetsort/exact/facts.h"
#include "facetsort/exact/plane_points.h"
#include "facetsort/exact/exact_sorter.h"
#include "facetsort/exact/presort.h"

#include "facetsort/scene/object_draw.h"
#include "facetsort/scene/galacean_order.h"
#include "facetsort/scene/babylon_order.h"
#include "facetsort/scene/three_order.h"
#include "facetsort/scene/panda3d_order.h"
#include "facetsort/scene/engine_settings.h"
#include "facetsort/scene/scene.h"
#include "facetsort/scene/read_scene.h"
#include "facetsort/scene/merge.h"
#include "facetsort/scene/scene_draw_order.h"
#include "facetsort/scene/draw_runs.h"
#include "facetsort/scene/scene_sorter.h"
#include "facetsort/scene/draw_costs.h"
#include "facetsort/scene/write_scene.h"

#include "facetsort/blend/view.h"
#include "facetsort/blend/shading.h"
#include "facetsort/blend/texture.h"
#include "facetsort/blend/image.h"
#include "facetsort/blend/source_over.h"
#include "facetsort/blend/rasteriser.h"
#include "facetsort/blend/fragment_lists.h"
#include "facetsort/blend/strategy.h"
#include "facetsort/blend/swap_error.h"

#include "facetsort/check/verdict.h"
#include "facetsort/check/picture_verdict.h"
#include "facetsort/check/embree_referee.h"

#include "facetsort/presort/index_buffers.h"
#include "facetsort/presort/write_gltf.h"

#include "facetsort/plan/convex_parts.h"
#include "facetsort/plan/plan.h"
#include "facetsort/plan/planned_renderer.h"

#include "facetsort/report/machine.h"
#include "facetsort/report/row.h"
#include "facetsort/report/timing.h"
#include "facetsort/report/image_file.h"
#include "facetsort/report/difference_image.h"
#include "facetsort/report/summary.h"
#include "facetsort/report/write_report.h"
// clang-format on
