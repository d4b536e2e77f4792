#include "facetsort/order/method.h"

#include <array>

namespace facetsort {
namespace {

constexpr std::array methods = {Method::centroid_distance, Method::centroid_depth, Method::bounds_centre,
                                Method::first_vertex,      Method::nearest_vertex, Method::farthest_vertex,
                                Method::exact,             Method::exact_tree,     Method::presorted};
constexpr std::size_t exact_methods = 3;
constexpr std::array<std::string_view, methods.size()> names = {"centroid_distance", "centroid_depth",
                                                                "bounds_centre",     "first_vertex",
                                                                "nearest_vertex",    "farthest_vertex",
                                                                "exact",             "exact_tree",
                                                                "presorted"};

}  // namespace

std::span<const Method> all_methods() { return methods; }

std::span<const Method> depth_key_methods() { return std::span(methods).first(methods.size() - exact_methods); }

bool is_exact(Method method) { return method >= Method::exact; }

std::string_view method_name(Method method) { return names[static_cast<std::size_t>(method)]; }

std::optional<Method> method_from_name(std::string_view name) {
  if (name == "parametric_centre") return Method::centroid_depth;
  for (const Method method : methods) {
    if (name == method_name(method)) return method;
  }
  return std::nullopt;
}

}  // namespace facetsort
