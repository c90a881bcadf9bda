#include "dem_templates/geometry/solids.hpp"

#include <algorithm>
#include <map>

#include "common/assert.hpp"
#include "common/units.hpp"

namespace granary::dem {
namespace {

// The two directions across the axis, so that (axis, first, second) is right-handed.
std::pair<Vec3, Vec3> across(Axis axis) {
  if (axis == Axis::x) return {{0, 1, 0}, {0, 0, 1}};
  if (axis == Axis::y) return {{0, 0, 1}, {1, 0, 0}};
  return {{1, 0, 0}, {0, 1, 0}};
}

// Vertex numbers of a surface of revolution: [profile point][around]; a point on the axis is one vertex.
using Rings = std::vector<std::vector<int>>;

Rings add_rings(Mesh& mesh, Axis axis, const std::vector<ProfilePoint>& profile, int n_around) {
  GRANARY_ASSERT(profile.size() >= 3 && profile.front().radius == 0.0 && profile.back().radius == 0.0);
  const auto [first, second] = across(axis);
  Rings rings;
  for (const ProfilePoint& p : profile) {
    std::vector<int> ring;
    for (int j = 0; j < n_around; ++j) {
      if (j > 0 && p.radius == 0.0) {
        ring.push_back(ring.front());
        continue;
      }
      const double angle = 2.0 * kPi * j / n_around;
      ring.push_back(static_cast<int>(mesh.vertex.size()));
      mesh.vertex.push_back(p.along * unit(axis) + (p.radius * std::cos(angle)) * first +
                            (p.radius * std::sin(angle)) * second);
    }
    rings.push_back(ring);
  }
  return rings;
}

// A quad (or a triangle, where two corners are one) given in order around it; `flip` turns it to the other side.
void add_quad(Mesh& mesh, int a, int b, int c, int d, bool flip) {
  const auto add = [&](int p, int q, int r) {
    if (p == q || q == r || r == p) return;
    if (flip) std::swap(q, r);
    mesh.triangle.push_back({p, q, r});
  };
  add(a, b, c);
  add(a, c, d);
}

struct Surface {
  Mesh& mesh;
  const Rings& rings;
  bool inwards;  // looks at the axis
};

// The surface of revolution with its open cells left out and its raised cells lifted on side walls.
void add_surface(const Surface& surface, const Vessel& form, const std::function<Vec3(Vec3)>& lift) {
  Mesh& mesh = surface.mesh;
  const int n = form.n_around, m = static_cast<int>(surface.rings.size()) - 1;
  const auto is = [&](const Vessel::Cells& cells, int i, int j) {
    return cells && i >= 0 && i < m && cells(i, (j + n) % n);
  };
  const auto ground = [&](int i, int j) { return surface.rings[i][(j + n) % n]; };
  std::map<int, int> lifted;
  const auto top = [&](int i, int j) {
    const auto [at, is_new] = lifted.try_emplace(ground(i, j), static_cast<int>(mesh.vertex.size()));
    if (is_new) mesh.vertex.push_back(lift(mesh.vertex[ground(i, j)]));
    return at->second;
  };
  for (int i = 0; i < m; ++i)
    for (int j = 0; j < n; ++j) {
      if (is(form.open, i, j)) continue;
      if (!is(form.raised, i, j)) {
        add_quad(mesh, ground(i, j), ground(i, j + 1), ground(i + 1, j + 1), ground(i + 1, j), surface.inwards);
        continue;
      }
      add_quad(mesh, top(i, j), top(i, j + 1), top(i + 1, j + 1), top(i + 1, j), surface.inwards);
      const std::array<std::array<int, 6>, 4> sides{{// neighbour's cell offset, then the edge's two corners
                                                     {-1, 0, i, j, i, j + 1},
                                                     {0, 1, i, j + 1, i + 1, j + 1},
                                                     {1, 0, i + 1, j + 1, i + 1, j},
                                                     {0, -1, i + 1, j, i, j}}};
      for (const auto& [di, dj, ai, aj, bi, bj] : sides)
        if (!is(form.raised, i + di, j + dj))
          add_quad(mesh, ground(ai, aj), ground(bi, bj), top(bi, bj), top(ai, aj), surface.inwards);
    }
}

// Blade directions: along its length, along its width, and the way it goes.
struct BladeFrame {
  Vec3 out, wide, ahead;
};
BladeFrame frame_of(const Blade& form) {
  const auto [first, second] = across(form.axis);
  const Vec3 out = std::cos(form.angle) * first + std::sin(form.angle) * second;
  const Vec3 ahead = std::cos(form.angle) * second - std::sin(form.angle) * first;  // axis x out
  return {out, std::cos(form.pitch) * unit(form.axis) - std::sin(form.pitch) * ahead, ahead};
}

// Thickness measured along the way it goes.
double thickness_ahead(const Blade& form) { return form.thickness / std::cos(form.pitch); }

// Length of the blade from the axis so that its tip's outermost corners lie on the tip circle.
double reach(const Blade& form) {
  const double aside = 0.5 * (form.width * std::abs(std::sin(form.pitch)) + thickness_ahead(form));
  GRANARY_ASSERT(aside < form.tip_radius, aside);
  return std::sqrt(form.tip_radius * form.tip_radius - aside * aside);
}

}  // namespace

Vec3 unit(Axis axis) { return {axis == Axis::x ? 1.0 : 0.0, axis == Axis::y ? 1.0 : 0.0, axis == Axis::z ? 1.0 : 0.0}; }

double touching_radius(double radius, int n_around) { return radius / std::cos(kPi / n_around); }

Mesh body_of_revolution(Axis axis, const std::vector<ProfilePoint>& profile, int n_around) {
  Mesh mesh;
  const Rings rings = add_rings(mesh, axis, profile, n_around);
  Vessel whole;
  whole.n_around = n_around;
  add_surface({mesh, rings, false}, whole, nullptr);
  return mesh;
}

Mesh vessel(const Vessel& form) {
  GRANARY_ASSERT(form.inner.size() == form.outer.size());
  Mesh mesh;
  const Rings inner = add_rings(mesh, form.axis, form.inner, form.n_around);
  const Rings outer = add_rings(mesh, form.axis, form.outer, form.n_around);
  add_surface({mesh, inner, true}, form, form.lift_inner);
  add_surface({mesh, outer, false}, form, form.lift_outer);
  const int n = form.n_around, m = static_cast<int>(inner.size()) - 1;
  const auto open = [&](int i, int j) { return form.open && i >= 0 && i < m && form.open(i, (j + n) % n); };
  for (int i = 0; i < m; ++i)
    for (int j = 0; j < n; ++j) {
      if (!open(i, j)) continue;
      const int next = (j + 1) % n;
      // The rim looks into the hole: against the order of its corners here.
      if (!open(i - 1, j)) add_quad(mesh, inner[i][j], inner[i][next], outer[i][next], outer[i][j], true);
      if (!open(i + 1, j))
        add_quad(mesh, inner[i + 1][next], inner[i + 1][j], outer[i + 1][j], outer[i + 1][next], true);
      if (!open(i, j - 1)) add_quad(mesh, inner[i + 1][j], inner[i][j], outer[i][j], outer[i + 1][j], true);
      if (!open(i, j + 1)) add_quad(mesh, inner[i][next], inner[i + 1][next], outer[i + 1][next], outer[i][next], true);
    }
  return mesh;
}

Mesh blade(const Blade& form) {
  const BladeFrame f = frame_of(form);
  Mesh mesh;
  for (int corner = 0; corner < 8; ++corner) {
    const double out = corner & 1 ? reach(form) : form.root_radius;
    const double wide = (corner & 2 ? 0.5 : -0.5) * form.width;
    const double thick = (corner & 4 ? 0.5 : -0.5) * thickness_ahead(form);
    mesh.vertex.push_back(form.centre + out * f.out + wide * f.wide + thick * f.ahead);
  }
  const int faces[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
  // (out, wide, ahead) is left-handed for the rotor's sense of turning, or not: orient by the volume.
  for (const auto& q : faces) add_quad(mesh, q[0], q[1], q[2], q[3], false);
  if (volume(mesh) < 0.0)
    for (Corners& t : mesh.triangle) std::swap(t[1], t[2]);
  return mesh;
}

double half_extent(const Blade& form) { return 0.5 * form.width * std::cos(form.pitch); }

double blade_volume(const Blade& form, double shaft_radius) {
  return std::max(0.0, reach(form) - std::max(form.root_radius, shaft_radius)) * form.width * form.thickness;
}

}  // namespace granary::dem
