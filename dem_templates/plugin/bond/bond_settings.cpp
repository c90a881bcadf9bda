#include "dem_templates/plugin/bond/bond_settings.hpp"

namespace granary::dem {

using Range = FixArguments::Range;

std::vector<FixArguments::Keyword> bond_keywords() {
  return {{"normal_stiffness"},
          {"shear_stiffness"},
          {"tensile_strength"},
          {"shear_strength"},
          {"radius_scale"},
          {"radius"},
          {"gap"},
          {"damping"},
          {"criterion"},
          {"weibull"},
          {"normal"},
          {"seed"},
          {"create"},
          {"among"},
          {"fragments"},
          {"every"},
          {"breaks"},
          {"look"},
          {"cause_window"}};
}

BondSettings read_bond_settings(FixArguments& arguments) {
  BondSettings s;
  s.material.normal_stiffness = arguments.number("normal_stiffness", Range::positive());
  s.material.shear_stiffness = arguments.number("shear_stiffness", Range::positive());
  s.material.tensile_strength = arguments.number("tensile_strength", Range::positive());
  s.material.shear_strength = arguments.number("shear_strength", Range::positive());
  s.material.damping = arguments.number_or("damping", 0.0, Range::fraction());
  s.radius_scale = arguments.number_or("radius_scale", 1.0, Range::positive());
  s.radius = arguments.has("radius") ? arguments.number("radius", Range::positive()) : 0.0;
  if (arguments.has("radius") && arguments.has("radius_scale"))
    arguments.problem("'radius' and 'radius_scale' exclude each other: give one.");
  s.gap = arguments.number("gap", Range::not_negative());
  s.create = arguments.number_or("create", 0.0, Range::not_negative());

  const auto one_of = [&arguments](const std::string& keyword, const std::string& usual, const std::string& other) {
    const std::string word = arguments.text_or(keyword, usual);
    if (word != usual && word != other)
      arguments.problem("'" + keyword + "' is '" + word + "'; it must be " + usual + " or " + other + ".");
    return word == other;
  };
  s.material.combined = one_of("criterion", "two_tests", "combined");
  s.whole_group = one_of("among", "agglomerates", "group");

  if (arguments.has("weibull") && arguments.has("normal"))
    arguments.problem("'weibull' and 'normal' exclude each other: give one.");
  if (arguments.has("weibull")) {
    s.scatter = StrengthScatter::weibull;
    s.spread = arguments.number("weibull", Range{0.5, 1e3, true, true});
  } else if (arguments.has("normal")) {
    s.scatter = StrengthScatter::normal;
    s.spread = arguments.number("normal", Range::fraction());
  }
  s.seed = static_cast<std::uint64_t>(arguments.integer_or("seed", 1, Range::not_negative()));

  s.fragments = arguments.text_or("fragments", "");
  s.breaks = arguments.text_or("breaks", "");
  if (!s.fragments.empty()) s.every = arguments.integer("every", Range::between(1, 1e9));
  s.look = arguments.integer_or("look", s.look, Range::between(1, 1e6));
  s.cause_window = arguments.number_or("cause_window", s.cause_window, Range::not_negative());
  return s;
}

}  // namespace granary::dem
