// Agglomerates and their bonds as settings of a case: plain data, SI. One reader for case.json and for workflows, which
// write quantities with their units.
#pragma once

#include "common/json/reader.hpp"
#include "common/json/value.hpp"

namespace granary::dem {

/// Parallel bonds between touching spheres of an agglomerate (granary/bond).
struct Bonds {
  double radius = 0.96;                  ///< of a bond, over that of the smaller sphere
  double normal_stiffness = 5e9;         ///< of a bond's cross-section [N/m^3]
  double shear_stiffness_ratio = 0.458;  ///< shear over normal
  double tensile_strength = 1e5;         ///< [Pa]
  double shear_strength_ratio = 0.563;   ///< shear over tensile
  double strength_scatter = 0.0;         ///< standard deviation over the mean, of each bond's strengths
  double damping = 0.1;                  ///< of critical
  double gap = 0.05;                     ///< spheres nearer than this are bonded, over the sphere's radius
};

/// Agglomerates of equal spheres, put in whole at random places, instead of a population of single particles.
struct Agglomerates {
  int count = 100;
  int spheres = 37;                 ///< of each
  double sphere_diameter = 1.2e-3;  ///< [m]
  double diameter = 5e-3;           ///< of the ball the spheres are packed into; larger if they do not fit [m]
  double sample_every = 0.01;       ///< a line of fragments.jsonl each [s]
  Bonds bonds;
};

enum class Written { in_si, with_units };  ///< 0.0012, or "1.2 mm"

/// What is missing keeps its default. Adds to the reader's problems what is wrong, and what it does not know.
Agglomerates read_agglomerates(json::Reader in, Written written);
json::Value to_json(const Agglomerates& agglomerates);

}  // namespace granary::dem
