// Moment-based transparency against the published formulas, evaluated here in double by other means.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "blend/pictures.h"
#include "blend/sheets.h"

namespace facetsort {
namespace {

using Vector = std::vector<double>;

// By Gaussian elimination with pivots.
Vector solve(std::vector<Vector> rows, Vector right) {
  const std::size_t n = right.size();
  for (std::size_t i = 0; i < n; ++i) {
    std::size_t pivot = i;
    for (std::size_t r = i; r < n; ++r) pivot = std::abs(rows[r][i]) > std::abs(rows[pivot][i]) ? r : pivot;
    std::swap(rows[i], rows[pivot]);
    std::swap(right[i], right[pivot]);
    for (std::size_t r = i + 1; r < n; ++r) {
      const double factor = rows[r][i] / rows[i][i];
      for (std::size_t c = i; c < n; ++c) rows[r][c] -= factor * rows[i][c];
      right[r] -= factor * right[i];
    }
  }
  for (std::size_t i = n; i-- > 0;) {
    for (std::size_t c = i + 1; c < n; ++c) right[i] -= rows[i][c] * right[c];
    right[i] /= rows[i][i];
  }
  return right;
}

double value_at(const Vector& coefficients, double x) {
  double value = 0;
  for (std::size_t i = coefficients.size(); i-- > 0;) value = value * x + coefficients[i];
  return value;
}

// All of a polynomial with real roots, by bisection between those of its derivative.
Vector real_roots(const Vector& coefficients) {
  const std::size_t degree = coefficients.size() - 1;
  if (degree == 1) return {-coefficients[0] / coefficients[1]};
  Vector derivative;
  for (std::size_t i = 1; i <= degree; ++i) derivative.push_back(static_cast<double>(i) * coefficients[i]);
  Vector ends = real_roots(derivative);
  ends.insert(ends.begin(), -1e9);
  ends.push_back(1e9);
  Vector roots;
  for (std::size_t i = 0; i + 1 < ends.size(); ++i) {
    double low = ends[i], high = ends[i + 1];
    const bool rises = value_at(coefficients, high) > value_at(coefficients, low);
    for (int step = 0; step < 200; ++step) {
      const double middle = (low + high) / 2;
      ((value_at(coefficients, middle) < 0) == rises ? low : high) = middle;
    }
    roots.push_back(low);
  }
  return roots;
}

// The share before z0 and a quarter of that at it, of the measure on z0 and the roots of the kernel polynomial there.
double share_before(const Vector& moments, double z0) {
  const std::size_t n = moments.size() / 2 + 1;
  const auto moment = [&](std::size_t j) { return j == 0 ? 1.0 : moments[j - 1]; };
  std::vector<Vector> hankel(n, Vector(n)), vandermonde(n, Vector(n));
  Vector powers(n), first_moments(n);
  for (std::size_t r = 0; r < n; ++r) {
    powers[r] = std::pow(z0, static_cast<double>(r));
    first_moments[r] = moment(r);
    for (std::size_t c = 0; c < n; ++c) hankel[r][c] = moment(r + c);
  }
  Vector points = real_roots(solve(hankel, powers));
  points.insert(points.begin(), z0);
  for (std::size_t r = 0; r < n; ++r) {
    for (std::size_t c = 0; c < n; ++c) vandermonde[r][c] = std::pow(points[c], static_cast<double>(r));
  }
  const Vector weights = solve(vandermonde, first_moments);
  double share = 0.25 * weights[0];
  for (std::size_t i = 1; i < n; ++i) share += points[i] < z0 ? weights[i] : 0;
  return share;
}

glm::vec4 by_formula(std::span<const Sheet> layers, int count, Projection projection, const glm::vec4& clear_colour) {
  const Vector towards = count == 4 ? Vector{0, 0.375, 0, 0.375} : Vector{0, 0.48, 0, 0.451, 0, 0.45};
  const double bias = count == 4 ? 5e-7 : 5e-6;
  const auto ends = std::minmax_element(layers.begin(), layers.end(),
                                        [](const Sheet& a, const Sheet& b) { return a.distance < b.distance; });
  const double near = static_cast<double>(ends.first->distance), far = static_cast<double>(ends.second->distance);
  const auto warped = [&](double distance) {
    if (projection == Projection::orthographic) return 2 * (distance - near) / (far - near) - 1;
    return 2 * std::log(distance / near) / std::log(far / near) - 1;
  };
  const auto absorbance = [](const Sheet& sheet) {
    return std::min(-std::log(1 - static_cast<double>(sheet.alpha)), 10.0);
  };
  double total = 0;
  Vector moments(static_cast<std::size_t>(count), 0.0);
  for (const Sheet& sheet : layers) {
    total += absorbance(sheet);
    for (std::size_t j = 0; j < moments.size(); ++j) {
      moments[j] +=
          absorbance(sheet) * std::pow(warped(static_cast<double>(sheet.distance)), static_cast<double>(j + 1));
    }
  }
  for (std::size_t j = 0; j < moments.size(); ++j) moments[j] = (1 - bias) * moments[j] / total + bias * towards[j];
  glm::dvec4 sum(0);
  for (const Sheet& sheet : layers) {
    const double share = share_before(moments, warped(static_cast<double>(sheet.distance)));
    sum += std::exp(-total * share) * glm::dvec4(sheet.premultiplied());
  }
  const double through = std::exp(-total);
  return glm::vec4((1 - through) / sum.a * sum + through * glm::dvec4(clear_colour));
}

// Two points are what four moments (of three: six) can be of: the measure is found as it is, but for the bias. So a
// quarter of a layer's own absorbance counts, and all that of those before it: with transparencies t1 and t2, visible
// are t1^(1/4) and t1 t2^(1/4). The sum is scaled to the opacity 1 - t1 t2.
TEST(MomentBased, TwoLayersByHand) {
  // t = 0.5 and 0.5: shares of 1 : 0.5 of the opacity 0.75, which is source-over.
  const Sheet equal[] = {{10, green, 0.5f}, {5, red, 0.5f}};
  // t = 0.1 and 0.75: visible 0.5623413 and 0.0930605, times alpha 0.5061072 and 0.0232651; their sum is 0.5293723 and
  // the opacity 0.925: red 0.8843478, green 0.0406522.
  const Sheet uneven[] = {{10, green, 0.25f}, {5, red, 0.9f}};
  for (const int count : {4, 6}) {
    SCOPED_TRACE(count);
    const auto draw = [&](std::span<const Sheet> layers, Projection projection) {
      return draw_sheets(layers, sheets_view(5, 3, projection), OrderIndependent::moments, count);
    };
    for (const Projection projection : {Projection::perspective, Projection::orthographic}) {
      expect_colour(draw(equal, projection), {0.5f, 0.25f, 0, 1}, 1e-5f);
      expect_colour(draw(uneven, projection), {0.8843478f, 0.0406522f, 0, 1}, 1e-5f);
    }
  }
}

TEST(MomentBased, SixMomentsTellThreeLayers) {
  const Sheet layers[] = {{5, red, 0.5f}, {7, green, 0.5f}, {10, blue, 0.5f}};
  const Image image = draw_sheets(layers, sheets_view(), OrderIndependent::moments, 6);
  expect_colour(image, {0.5f, 0.25f, 0.125f, 1}, 1e-5f);
}

TEST(MomentBased, AbsorbanceOfOpaqueLayersEndsAtTen) {
  const Sheet layers[] = {{10, green, 0.5f}, {5, red, 1}};
  // Visible: e^-2.5 and e^-10 0.5^(1/4), times alpha 0.0820850 and 1.909e-5; opacity 1 - 0.5 e^-10.
  for (const int count : {4, 6}) {
    expect_colour(draw_sheets(layers, sheets_view(), OrderIndependent::moments, count, {0, 0, 0, 1}),
                  {0.9997447f, 0.0002325f, 0, 1}, 1e-5f);
  }
}

TEST(MomentBased, ManyLayersAsTheFormulasSay) {
  std::mt19937 random(17);
  std::uniform_real_distribution<float> uniform(0, 1);
  const glm::vec4 clear_colour(0.1f, 0.2f, 0.3f, 0.4f);
  for (int trial = 0; trial < 40; ++trial) {
    SCOPED_TRACE(trial);
    std::vector<Sheet> layers;
    const int count = 4 + trial % 7;
    for (int i = 0; i < count; ++i) {
      // At least a third of an even step apart: what the moments of closer ones are is up to rounding.
      const float distance = 2 + 7 * (static_cast<float>(i) + 0.6f * uniform(random)) / static_cast<float>(count);
      const glm::vec3 straight(uniform(random), uniform(random), uniform(random));
      layers.push_back({distance, straight, i % 3 == 0 ? 0.05f : 0.1f + 0.8f * uniform(random)});
    }
    std::shuffle(layers.begin(), layers.end(), random);
    for (const Projection projection : {Projection::perspective, Projection::orthographic}) {
      for (const int moments : {4, 6}) {
        SCOPED_TRACE(moments);
        // Of up to ten layers six moments in float are no longer all that the formulas have: 1.5e-5 was seen.
        const float tolerance = moments == 4 ? 1e-5f : 3e-5f;
        const View view = sheets_view(3, 1, projection);
        expect_colour(draw_sheets(layers, view, OrderIndependent::moments, moments, clear_colour),
                      by_formula(layers, moments, projection, clear_colour), tolerance);
      }
    }
  }
}

// Where rounding may make moments impossible, all stays between what the layers' colours allow.
TEST(MomentBased, LayersCloseTogetherStayWithinTheirColours) {
  std::mt19937 random(5);
  std::uniform_real_distribution<float> uniform(0, 1);
  for (int trial = 0; trial < 200; ++trial) {
    std::vector<Sheet> layers;
    for (int i = 0; i < 1 + trial % 9; ++i) {
      const float spread = trial % 2 == 0 ? 1e-4f : 1e-7f;
      const float distance = (i % 3 == 0 ? 4.0f : 9.0f) * (1 + spread * uniform(random));
      layers.push_back({distance, {0.5f, uniform(random), 1}, uniform(random)});
    }
    for (const int moments : {4, 6}) {
      const Image image = draw_sheets(layers, sheets_view(3, 1), OrderIndependent::moments, moments);
      for (const glm::vec4& pixel : image.pixels) {
        ASSERT_NEAR(pixel.b, 2 * pixel.r, 1e-5f) << trial;
        ASSERT_GE(pixel.g, 0.0f);
        ASSERT_LE(pixel.g, pixel.b * 1.00001f);
        ASSERT_LE(pixel.b, 1.00001f);
        ASSERT_NEAR(pixel.a, 1, 1e-5f);
      }
    }
  }
}

}  // namespace
}  // namespace facetsort
