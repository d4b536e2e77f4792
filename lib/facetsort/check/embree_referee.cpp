#include "facetsort/check/embree_referee.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>

#include "facetsort/base/parallel.h"
#include "facetsort/facets/facets.h"

namespace facetsort {

// The mesh as Embree holds it: moved so that its box is centred on the origin and scaled by a power of two so that its
// largest coordinate lies in [1, 2), whatever its own place and size.
struct EmbreeReferee::State {
  explicit State(const MeshView& view);
  ~State();
  State(const State&) = delete;
  State& operator=(const State&) = delete;

  glm::vec3 placed(const glm::dvec3& offset_from_centre) const { return glm::vec3(offset_from_centre * scale); }

  MeshView mesh;
  glm::dvec3 centre;
  double radius;                    // of a sphere around centre that holds every facet
  double scale;                     // a power of two
  std::vector<glm::vec4> vertices;  // placed; the fourth coordinate is the padding that Embree asks for
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;
  RTCError error = RTC_ERROR_NONE;  // the first that Embree reported, and its words
  std::string error_message;
};

namespace {

// The rounding of one double operation.
constexpr double unit_roundoff = 0x1p-53;

// How far, in placed coordinates, a facet's box is widened so that traversal in float32 can't miss it. Corners (below
// 2), ray origins (below 8) and directions over paths below 16 are rounded by 2^-24 each: less than 2^-19 together.
constexpr float box_margin = 0x1p-18f;

// Below this sine of the angle between ray and facet, half of a float's digits are gone from the facet's depth.
constexpr double grazing_sine = 0x1p-12;

// What traversal says of one ray. Entries are 2 * facet where the ray meets the facet's widened box, and
// 2 * facet + 1 where Embree's own triangle test finds a hit.
struct TraversalContext {
  RTCIntersectContext embree;  // first: Embree hands back a pointer to it
  std::vector<std::uint64_t>* proposals;
};

void propose(RTCIntersectContext* context, std::uint64_t proposal) {
  reinterpret_cast<TraversalContext*>(context)->proposals->push_back(proposal);
}

void facet_box(const RTCBoundsFunctionArguments* arguments) {
  const auto& state = *static_cast<const EmbreeReferee::State*>(arguments->geometryUserPtr);
  const glm::uvec3 triangle = state.mesh.triangles[arguments->primID];
  const glm::vec3 a(state.vertices[triangle.x]), b(state.vertices[triangle.y]), c(state.vertices[triangle.z]);
  const glm::vec3 lower = glm::min(a, glm::min(b, c)) - box_margin;
  const glm::vec3 upper = glm::max(a, glm::max(b, c)) + box_margin;
  RTCBounds& bounds = *arguments->bounds_o;
  bounds.lower_x = lower.x, bounds.lower_y = lower.y, bounds.lower_z = lower.z;
  bounds.upper_x = upper.x, bounds.upper_y = upper.y, bounds.upper_z = upper.z;
}

void meet_box(const RTCIntersectFunctionNArguments* arguments) {
  assert(arguments->N == 1);
  if (arguments->valid[0]) propose(arguments->context, 2 * std::uint64_t{arguments->primID});
}

// Rejects every hit after noting it: the ray goes on to the next.
void meet_triangle(const RTCFilterFunctionNArguments* arguments) {
  assert(arguments->N == 1);
  if (!arguments->valid[0]) return;
  propose(arguments->context, 2 * std::uint64_t{RTCHitN_primID(arguments->hit, 1, 0)} + 1);
  arguments->valid[0] = 0;
}

void remember_error(void* user, RTCError code, const char* message) {
  auto& state = *static_cast<EmbreeReferee::State*>(user);
  if (state.error != RTC_ERROR_NONE) return;
  state.error = code;
  state.error_message = message ? message : "no message";
}

// A ray with an orthonormal frame across it.
struct FramedRay {
  FramedRay(const Ray& r, bool perspective) : ray(r) {
    // In perspective the origin is the eye; in an orthographic view it was computed, and rounded twice.
    const glm::dvec3 o = glm::abs(r.origin);
    if (!perspective) origin_reach = 2 * (o.x + o.y + o.z);
    const glm::dvec3 size = glm::abs(ray.direction);
    const glm::dvec3 axis = size.x <= size.y && size.x <= size.z ? glm::dvec3(1, 0, 0)
                            : size.y <= size.z                   ? glm::dvec3(0, 1, 0)
                                                                 : glm::dvec3(0, 0, 1);
    const glm::dvec3 across = glm::cross(axis, ray.direction);
    u = across / std::sqrt(glm::dot(across, across));
    v = glm::cross(ray.direction, u);
  }

  Ray ray;
  glm::dvec3 u, v;
  double origin_reach = 0;  // the origin is off by less than 2^-53 of this
};

enum class Meeting { miss, cut_off, hit, in_doubt, near_plane };

struct MeasuredFacet {
  Meeting meeting = Meeting::miss;
  double depth = 0, error = 0;
  bool is_grazing = false, is_back = false;
};

// Where a ray meets a facet, in double, with certainty or with a doubt.
//
// Corners relative to the ray's origin, a_i, are written in the ray's frame: p_i = (u . a_i, v . a_i) across and t_i
// along. The ray passes inside where the edge functions E_i = p_(i+1) x p_(i+2) have one sign, at the depth
// t = sum E_i t_i / sum E_i: the barycentric mean, which stays good on slivers.
//
// Rounding, with r = 2^-53, L the largest |x| + |y| + |z| of the a_i plus the reach of their origin, and P the largest
// coordinate of the p_i:
// - a_i is rounded by r and its origin by r of the reach, the frame is orthonormal to 4 r, a dot product of three terms
//   adds 3 r: each coordinate of p_i, and t_i, is off by less than e = 16 r L;
// - E_i then is off by less than 4 P e + 2 e^2 + 4 r P^2 < 72 r L (P + 8 r L), as P <= L: `edge_error`;
// - errors d_i of the E_i move t by sum d_i (t_i - t) / sum (E_i + d_i), at most 3 edge_error T / (|S| - 3 edge_error),
//   where T is the range of the t_i, which holds t, and S = sum E_i. Where every |E_i| > edge_error the denominator is
//   positive, and t is in the range anyway, so the move is at most T. Measured from the smallest t_i, sums and
//   quotient add less than 10 r T, and t_i itself and the last sum 16 r L + r L.
MeasuredFacet measure(const MeshView& mesh, std::uint32_t facet, const FramedRay& frame, double near_depth) {
  double p[3][2], t[3];
  double length = 0, breadth = 0;
  for (int i = 0; i < 3; ++i) {
    const glm::dvec3 a = glm::dvec3(mesh.corner(facet, i)) - frame.ray.origin;
    p[i][0] = glm::dot(frame.u, a);
    p[i][1] = glm::dot(frame.v, a);
    t[i] = glm::dot(frame.ray.direction, a);
    length = std::max(length, std::abs(a.x) + std::abs(a.y) + std::abs(a.z));
    breadth = std::max({breadth, std::abs(p[i][0]), std::abs(p[i][1])});
  }
  length += frame.origin_reach;
  const double lowest = std::min({t[0], t[1], t[2]}), highest = std::max({t[0], t[1], t[2]});
  const double corner_error = 17 * unit_roundoff * length;
  MeasuredFacet measured;
  if (highest + corner_error < near_depth) {
    measured.meeting = Meeting::cut_off;
    return measured;
  }

  double edge[3];
  for (int i = 0; i < 3; ++i) {
    const auto& from = p[(i + 1) % 3];
    const auto& to = p[(i + 2) % 3];
    edge[i] = from[0] * to[1] - from[1] * to[0];
  }
  const double edge_error = 72 * unit_roundoff * length * (breadth + 8 * unit_roundoff * length);
  const double smallest = std::min({edge[0], edge[1], edge[2]}), largest = std::max({edge[0], edge[1], edge[2]});
  const double sum = edge[0] + edge[1] + edge[2];
  const glm::dvec3 a(mesh.corner(facet, 0)), b(mesh.corner(facet, 1)), c(mesh.corner(facet, 2));
  const glm::dvec3 normal = glm::cross(b - a, c - a);
  measured.is_grazing = sum * sum <= grazing_sine * grazing_sine * glm::dot(normal, normal);
  if (smallest < -edge_error && largest > edge_error) return measured;
  if (smallest <= edge_error && largest >= -edge_error) {
    measured.meeting = Meeting::in_doubt;
    return measured;
  }

  measured.is_back = sum > 0;  // counter-clockwise as seen along the ray, in the right-handed frame
  const double range = highest - lowest;
  const double above_lowest = (edge[0] * (t[0] - lowest) + edge[1] * (t[1] - lowest) + edge[2] * (t[2] - lowest)) / sum;
  const double certain_sum = std::abs(sum) - 3 * edge_error;
  const double moved = certain_sum > 3 * edge_error ? 3 * edge_error * range / certain_sum : range;
  measured.depth = lowest + above_lowest;
  measured.error = moved + corner_error + 10 * unit_roundoff * range;
  if (measured.depth + measured.error < near_depth)
    measured.meeting = Meeting::cut_off;
  else if (measured.depth - measured.error <= near_depth)
    measured.meeting = Meeting::near_plane;
  else
    measured.meeting = Meeting::hit;
  return measured;
}

enum class Judgement { judged, edge, grazing, near_plane };

// Casts one ray after the other, keeping its scratch.
class RayCaster {
 public:
  RayCaster(const EmbreeReferee::State& state, const Camera& camera) : state_(state), camera_(camera) {}

  // The hits of the ray through a pixel's centre; none where the ray can't be judged.
  Judgement cast(int x, int y) {
    hits_.clear();
    const FramedRay frame(camera_.pixel_ray(x, y), camera_.perspective);
    traverse(frame.ray);
    std::sort(proposals_.begin(), proposals_.end());
    for (auto proposal = proposals_.begin(); proposal != proposals_.end();) {
      const auto facet = static_cast<std::uint32_t>(*proposal / 2);
      bool hit_by_embree = false;
      for (; proposal != proposals_.end() && *proposal / 2 == facet; ++proposal) hit_by_embree |= *proposal % 2 == 1;
      const Judgement judgement = judge_facet(facet, hit_by_embree, frame);
      if (judgement != Judgement::judged) {
        hits_.clear();
        return judgement;
      }
    }
    std::sort(hits_.begin(), hits_.end(), [](const Fragment& a, const Fragment& b) {
      return a.depth > b.depth || (a.depth == b.depth && a.facet < b.facet);
    });
    return Judgement::judged;
  }

  const std::vector<Fragment>& hits() const { return hits_; }

 private:
  // Fills proposals_. The ray starts where it enters the mesh's sphere, or at a perspective eye inside it, so that far
  // eyes cost float32 no digits.
  void traverse(const Ray& ray) {
    proposals_.clear();
    const glm::dvec3 to_centre = state_.centre - ray.origin;
    const double nearest = glm::dot(to_centre, ray.direction);
    const glm::dvec3 aside = to_centre - nearest * ray.direction;
    // Rounding of `aside` counts when the eye is far: the sphere grows by it.
    const double sphere = state_.radius + 16 * unit_roundoff * (std::abs(nearest) + state_.radius);
    if (!(glm::dot(aside, aside) <= sphere * sphere)) return;
    if (camera_.perspective && nearest + sphere < 0) return;
    double start = nearest - 1.0625 * sphere;
    if (camera_.perspective) start = std::max(start, 0.0);
    const glm::vec3 origin = state_.placed((start - nearest) * ray.direction - aside);
    const glm::vec3 direction(ray.direction);

    RTCRayHit query;
    query.ray.org_x = origin.x, query.ray.org_y = origin.y, query.ray.org_z = origin.z;
    query.ray.dir_x = direction.x, query.ray.dir_y = direction.y, query.ray.dir_z = direction.z;
    query.ray.tnear = 0;
    query.ray.tfar = std::numeric_limits<float>::infinity();
    query.ray.time = 0;
    query.ray.mask = ~0u;
    query.ray.id = 0;
    query.ray.flags = 0;
    query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    TraversalContext context;
    rtcInitIntersectContext(&context.embree);
    context.proposals = &proposals_;
    rtcIntersect1(state_.scene, &context.embree, &query);
  }

  Judgement judge_facet(std::uint32_t facet, bool hit_by_embree, const FramedRay& frame) {
    const double near_depth = camera_.perspective
                                  ? camera_.near_distance / glm::dot(camera_.forward, frame.ray.direction)
                                  : -std::numeric_limits<double>::infinity();
    const MeasuredFacet measured = measure(state_.mesh, facet, frame, near_depth);
    switch (measured.meeting) {
      case Meeting::cut_off:
        return Judgement::judged;
      case Meeting::near_plane:
        return Judgement::near_plane;
      case Meeting::miss:
        if (!hit_by_embree) return Judgement::judged;
        break;
      case Meeting::hit:
        if (!hit_by_embree) break;
        if (measured.is_back && is_single_sided(state_.mesh, facet)) return Judgement::judged;
        hits_.push_back({facet, std::nextafter(static_cast<float>(measured.error), std::numeric_limits<float>::max()),
                         measured.depth});
        return Judgement::judged;
      case Meeting::in_doubt:
        break;
    }
    return measured.is_grazing ? Judgement::grazing : Judgement::edge;
  }

  const EmbreeReferee::State& state_;
  const Camera& camera_;
  std::vector<std::uint64_t> proposals_;
  std::vector<Fragment> hits_;
};

// What the rays of one row of pixels met.
struct Row {
  std::vector<Fragment> fragments;
  std::vector<std::uint32_t> counts;  // fragments of each pixel
  std::size_t rays = 0, edge = 0, grazing = 0, near_plane = 0;
};

void cast_row(RayCaster& caster, int y, int width, unsigned char* judged, Row& row) {
  row.counts.resize(static_cast<std::size_t>(width));
  for (int x = 0; x < width; ++x) {
    const Judgement judgement = caster.cast(x, y);
    row.fragments.insert(row.fragments.end(), caster.hits().begin(), caster.hits().end());
    row.counts[x] = static_cast<std::uint32_t>(caster.hits().size());
    judged[x] = judgement == Judgement::judged;
    row.edge += judgement == Judgement::edge;
    row.grazing += judgement == Judgement::grazing;
    row.near_plane += judgement == Judgement::near_plane;
    row.rays += judgement != Judgement::judged || !caster.hits().empty();
  }
}

// Joins the rows, in order, into lists that are already sized in width and height.
void join_rows(const std::vector<Row>& rows, FragmentLists& lists) {
  const auto width = static_cast<std::size_t>(lists.width);
  lists.offsets.assign(rows.size() * width + 1, 0);
  std::uint64_t total = 0;
  for (std::size_t y = 0; y < rows.size(); ++y) {
    for (std::size_t x = 0; x < width; ++x) {
      lists.offsets[y * width + x] = total;
      total += rows[y].counts[x];
    }
  }
  lists.offsets.back() = total;
  lists.fragments.resize(total);
  parallel_ranges(rows.size(), 16, [&](std::size_t begin, std::size_t end) {
    for (std::size_t y = begin; y < end; ++y)
      std::copy(rows[y].fragments.begin(), rows[y].fragments.end(),
                lists.fragments.begin() + static_cast<std::ptrdiff_t>(lists.offsets[y * width]));
  });
}

// Embree builds with denormals flushed to zero, and an arena of oneTBB keeps the floating-point mode in which its first
// work found the calling thread: if that were Embree's build, all later work of the arena would flush denormals. So
// some other work comes first.
void settle_floating_point_mode() {
  tbb::parallel_for(0, 2, [](int) {});
}

void add_triangles(EmbreeReferee::State& state) {
  const RTCGeometry triangles = rtcNewGeometry(state.device, RTC_GEOMETRY_TYPE_TRIANGLE);
  rtcSetSharedGeometryBuffer(triangles, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, state.vertices.data(), 0,
                             sizeof(glm::vec4), state.vertices.size());
  rtcSetSharedGeometryBuffer(triangles, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, state.mesh.triangles.data(), 0,
                             sizeof(glm::uvec3), state.mesh.triangles.size());
  rtcSetGeometryIntersectFilterFunction(triangles, meet_triangle);
  rtcCommitGeometry(triangles);
  rtcAttachGeometry(state.scene, triangles);
  rtcReleaseGeometry(triangles);
}

void add_boxes(EmbreeReferee::State& state) {
  const RTCGeometry boxes = rtcNewGeometry(state.device, RTC_GEOMETRY_TYPE_USER);
  rtcSetGeometryUserPrimitiveCount(boxes, static_cast<unsigned>(state.mesh.facet_count()));
  rtcSetGeometryUserData(boxes, &state);
  rtcSetGeometryBoundsFunction(boxes, facet_box, nullptr);
  rtcSetGeometryIntersectFunction(boxes, meet_box);
  rtcCommitGeometry(boxes);
  rtcAttachGeometry(state.scene, boxes);
  rtcReleaseGeometry(boxes);
}

}  // namespace

EmbreeReferee::State::State(const MeshView& view) : mesh(view) {
  const Box box = facet_bounds(mesh);
  const glm::dvec3 lowest(box.lowest), highest(box.highest);
  centre = 0.5 * (lowest + highest);
  const glm::dvec3 half = 0.5 * (highest - lowest);
  radius = std::sqrt(glm::dot(half, half)) * (1 + 8 * unit_roundoff);
  const double largest = std::max({half.x, half.y, half.z});
  scale = largest > 0 ? std::ldexp(1.0, -std::ilogb(largest)) : 1;
  vertices.reserve(mesh.vertex_count());
  for (const glm::vec3& position : mesh.positions) vertices.emplace_back(placed(glm::dvec3(position) - centre), 0.0f);
}

EmbreeReferee::State::~State() {
  if (scene) rtcReleaseScene(scene);
  if (device) rtcReleaseDevice(device);
}

EmbreeReferee::EmbreeReferee(std::unique_ptr<State> state) : state_(std::move(state)) {}
EmbreeReferee::EmbreeReferee(EmbreeReferee&&) noexcept = default;
EmbreeReferee& EmbreeReferee::operator=(EmbreeReferee&&) noexcept = default;
EmbreeReferee::~EmbreeReferee() = default;

Result<EmbreeReferee> EmbreeReferee::create(const MeshView& mesh) {
  settle_floating_point_mode();
  auto state = std::make_unique<State>(mesh);
  state->device = rtcNewDevice(nullptr);
  if (!state->device)
    return Status{Fault::bad_argument, "Embree: no device, error " + std::to_string(rtcGetDeviceError(nullptr))};
  rtcSetDeviceErrorFunction(state->device, remember_error, state.get());
  state->scene = rtcNewScene(state->device);
  // Robust: no hit is lost on an edge that two facets share.
  rtcSetSceneFlags(state->scene, RTC_SCENE_FLAG_ROBUST);
  add_triangles(*state);
  add_boxes(*state);
  rtcCommitScene(state->scene);
  if (state->error != RTC_ERROR_NONE) {
    const Fault fault = state->error == RTC_ERROR_OUT_OF_MEMORY ? Fault::out_of_memory : Fault::bad_argument;
    return Status{fault, "Embree: " + state->error_message};
  }
  return EmbreeReferee(std::move(state));
}

Result<RayHits> EmbreeReferee::cast(const View& view) const {
  if (Status status = validate(view); !status.ok()) return status;
  const Camera camera(view);
  const auto width = static_cast<std::size_t>(view.width);
  RayHits result;
  result.lists.width = view.width;
  result.lists.height = view.height;
  result.judged.resize(width * static_cast<std::size_t>(view.height));
  std::vector<Row> rows(static_cast<std::size_t>(view.height));
  parallel_ranges(rows.size(), 2, [&](std::size_t begin, std::size_t end) {
    RayCaster caster(*state_, camera);
    for (std::size_t y = begin; y < end; ++y)
      cast_row(caster, static_cast<int>(y), view.width, result.judged.data() + y * width, rows[y]);
  });
  join_rows(rows, result.lists);
  for (const Row& row : rows) {
    result.rays += row.rays;
    result.unjudged_edge += row.edge;
    result.unjudged_grazing += row.grazing;
    result.unjudged_near_plane += row.near_plane;
  }
  result.unjudged_rays = result.unjudged_edge + result.unjudged_grazing + result.unjudged_near_plane;
  return result;
}

}  // namespace facetsort
