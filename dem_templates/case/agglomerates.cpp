#include "dem_templates/case/agglomerates.hpp"

#include <array>

namespace granary::dem {
namespace {

using json::Range;
using json::Reader;

/// A number of T: how it is called, in which unit it is written ("" if in none), what is allowed.
template <class T>
struct Field {
  const char* key;
  double T::*value;
  const char* unit;
  Range range;
};

const std::array<Field<Bonds>, 8> kBonds{
    {{"radius", &Bonds::radius, "", Range::positive()},
     {"normal_stiffness", &Bonds::normal_stiffness, "N/m^3", Range::positive()},
     {"shear_stiffness_ratio", &Bonds::shear_stiffness_ratio, "", Range::positive()},
     {"tensile_strength", &Bonds::tensile_strength, "Pa", Range::positive()},
     {"shear_strength_ratio", &Bonds::shear_strength_ratio, "", Range::positive()},
     {"strength_scatter", &Bonds::strength_scatter, "", Range::fraction()},
     {"damping", &Bonds::damping, "", Range::fraction()},
     {"gap", &Bonds::gap, "", Range::not_negative()}}};

const std::array<Field<Agglomerates>, 3> kAgglomerates{
    {{"sphere_diameter", &Agglomerates::sphere_diameter, "m", Range::positive()},
     {"diameter", &Agglomerates::diameter, "m", Range::positive()},
     {"sample_every", &Agglomerates::sample_every, "s", Range::positive()}}};

template <class T>
void read(Reader& in, const Field<T>& field, Written written, T& into) {
  double& value = into.*field.value;
  value = written == Written::with_units && *field.unit != '\0'
              ? in.quantity_or(field.key, value, field.unit, field.range)
              : in.number_or(field.key, value, field.range);
}

Bonds read_bonds(Reader in, Written written) {
  Bonds bonds;
  for (const auto& field : kBonds) read(in, field, written, bonds);
  in.done();
  return bonds;
}

}  // namespace

Agglomerates read_agglomerates(Reader in, Written written) {
  Agglomerates all;
  all.count = static_cast<int>(in.integer_or("count", all.count, Range::between(1, 1e6)));
  all.spheres = static_cast<int>(in.integer_or("spheres", all.spheres, Range::between(1, 1e5)));
  for (const auto& field : kAgglomerates) read(in, field, written, all);
  if (all.diameter < all.sphere_diameter) in.problem("diameter", "it must be at least the sphere_diameter.");
  if (auto bonds = in.optional_section("bonds")) all.bonds = read_bonds(std::move(*bonds), written);
  in.done();
  return all;
}

json::Value to_json(const Agglomerates& all) {
  json::Value out = json::Value::object({{"count", all.count}, {"spheres", all.spheres}});
  for (const auto& field : kAgglomerates) out.set(field.key, all.*field.value);
  json::Value bonds = json::Value::object();
  for (const auto& field : kBonds) bonds.set(field.key, all.bonds.*field.value);
  out.set("bonds", std::move(bonds));
  return out;
}

}  // namespace granary::dem
