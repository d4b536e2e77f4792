// Geometry in rational numbers: slow, obvious, and independent of the library's predicates.
#pragma once

#include <array>
#include <boost/multiprecision/cpp_int.hpp>
#include <glm/glm.hpp>

namespace facetsort::rational {

using Number = boost::multiprecision::cpp_rational;

struct Point {
  Number x, y, z;

  Point(Number x_, Number y_, Number z_) : x(std::move(x_)), y(std::move(y_)), z(std::move(z_)) {}
  explicit Point(const glm::dvec3& p) : x(p.x), y(p.y), z(p.z) {}
  bool operator==(const Point& other) const { return x == other.x && y == other.y && z == other.z; }
};

inline Point operator-(const Point& a, const Point& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline Point operator+(const Point& a, const Point& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
inline Point operator*(const Number& s, const Point& a) {
  return {s * a.x, s * a.y, s * a.z};
}
inline Number dot(const Point& a, const Point& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
inline Point cross(const Point& a, const Point& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline bool is_zero(const Point& a) {
  return a.x == 0 && a.y == 0 && a.z == 0;
}

}  // namespace facetsort::rational
