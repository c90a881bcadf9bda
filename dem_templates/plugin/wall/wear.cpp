#include "dem_templates/plugin/wall/wear.hpp"

#include <fmt/format.h>

#include <cmath>
#include <iterator>

#include "dem_templates/plugin/wall/vectors.hpp"

namespace granary::dem {

double finnie_volume(double factor, double mass, double speed, double normal_speed) {
  if (normal_speed <= 0.0 || speed <= 0.0) return 0.0;
  constexpr double kForces = 2.0;  // K: vertical over horizontal force
  const double sine = std::fmin(1.0, normal_speed / speed), cosine = std::sqrt(1.0 - sine * sine);
  const bool shallow = sine <= kForces / 6.0 * cosine;
  const double f = shallow ? 2.0 * sine * cosine - 6.0 / kForces * sine * sine : kForces / 6.0 * cosine * cosine;
  return factor * mass * speed * speed * f;
}

std::string wear_vtk(const std::vector<Triangle>& triangles, const Wear& wear, const std::string& title) {
  std::string text = fmt::format("# vtk DataFile Version 3.0\n{}\nASCII\nDATASET POLYDATA\nPOINTS {} double\n", title,
                                 3 * triangles.size());
  auto out = std::back_inserter(text);
  for (const Triangle& triangle : triangles)
    for (const Vector3& p : triangle) fmt::format_to(out, "{:.9g} {:.9g} {:.9g}\n", p[0], p[1], p[2]);
  fmt::format_to(out, "POLYGONS {} {}\n", triangles.size(), 4 * triangles.size());
  for (std::size_t t = 0; t < triangles.size(); ++t) fmt::format_to(out, "3 {} {} {}\n", 3 * t, 3 * t + 1, 3 * t + 2);

  fmt::format_to(out, "CELL_DATA {}\n", triangles.size());
  const auto put = [&](const char* name, const auto& value_of) {
    fmt::format_to(out, "SCALARS {} double 1\nLOOKUP_TABLE default\n", name);
    for (std::size_t t = 0; t < triangles.size(); ++t) fmt::format_to(out, "{:.9g}\n", value_of(t));
  };
  const auto area = [&](std::size_t t) {
    const auto& [a, b, c] = triangles[t];
    return 0.5 * norm(cross(b - a, c - a));
  };
  put("volume_by_sliding_m3", [&](std::size_t t) { return wear.by_sliding[t]; });
  put("volume_by_impacts_m3", [&](std::size_t t) { return wear.by_impacts[t]; });
  put("depth_by_sliding_m", [&](std::size_t t) { return wear.by_sliding[t] / area(t); });
  put("depth_by_impacts_m", [&](std::size_t t) { return wear.by_impacts[t] / area(t); });
  return text;
}

}  // namespace granary::dem
