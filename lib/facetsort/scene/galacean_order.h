// The order in which Galacean draws whole objects. Read from @galacean/engine-core 1.6.13: BaseMaterial (isTransparent,
// alphaCutoff), Renderer._prepareRender, BasicRenderPipeline.pushRenderElement and RenderQueue.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <optional>
#include <span>
#include <vector>

#include "facetsort/scene/object_draw.h"

namespace facetsort {

enum class GalaceanRenderFace { front, back, double_sided };

// A BaseMaterial, as far as the order reads it.
struct GalaceanMaterial {
  bool is_transparent = false;
  double alpha_cutoff = 0;  // 0: nothing is discarded
  GalaceanRenderFace render_face = GalaceanRenderFace::front;
  // depthState.writeEnabled; unset: as isTransparent leaves it, off if transparent
  std::optional<bool> depth_write = {};
  bool depth_test = true;  // depthState.enabled
};

// A sub-mesh of a renderer.
struct GalaceanItem {
  GalaceanMaterial material = {};
  double priority = 0;                      // of the renderer; smaller is drawn first
  glm::dvec3 bounds_min{0}, bounds_max{0};  // of the renderer, in world space
};

struct GalaceanCamera {
  glm::dvec3 position{0};        // in world space
  glm::dvec3 forward{0, 0, -1};  // unit vector along the view; read if orthographic
  bool is_orthographic = false;
};

enum class GalaceanQueue { opaque, alpha_test, transparent };

// Transparency is asked before the cutoff: a transparent material with a cutoff is in the transparent queue.
GalaceanQueue galacean_queue(const GalaceanMaterial& material);

// From the camera to the centre of the bounding box: along the view direction (signed) if the camera is orthographic,
// else the square of the straight distance. In double, each sum from left to right, as JavaScript has it: equal to the
// engine's own to the bit.
double galacean_distance_for_sort(const GalaceanItem& item, const GalaceanCamera& camera);

// What a queue sorts.
struct GalaceanElement {
  std::uint32_t item = 0;
  double priority = 0;
  double distance_for_sort = 0;
};
// RenderQueue.compareForOpaque and compareForTransparent: below 0 where `a` is drawn first, above 0 where `b` is.
// Smaller priority first, then near to far, or far to near.
double galacean_compare_for_opaque(const GalaceanElement& a, const GalaceanElement& b);
double galacean_compare_for_transparent(const GalaceanElement& a, const GalaceanElement& b);

// The draws of a frame: the opaque queue, alpha test, transparent, each item once. Items are given in the order in
// which the pipeline pushes them, which is from the renderer last added to the scene to the first; sub-meshes of a
// renderer follow each other. Ties: the earlier item first. That is what the engine does with up to ten renderers in a
// queue (where transparent ones count in the alpha-test queue, too: it draws their shadows); above, its quicksort
// leaves ties in no order that it promises. Allocates; safe from several threads at once.
std::vector<ObjectDraw> galacean_draw_order(std::span<const GalaceanItem> items, const GalaceanCamera& camera);

}  // namespace facetsort
