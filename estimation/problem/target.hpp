// What was measured: one datum, or one size distribution, at a time and a place of an experiment, with its error.
#pragma once

#include <string>
#include <vector>

#include "common/json/value.hpp"

namespace granary::estimation {

enum class Quantity {
  d10,             ///< of the volume-weighted size distribution [m]
  d50,             ///< [m]
  d90,             ///< [m]
  number,          ///< particles in the compartment; at the outlet: particles per time [1/s]
  porosity,        ///< (liquid + gas) over particle volume [-]
  liquid_content,  ///< mass of liquid over mass of dry solid [-]
  solid_mass,      ///< in the compartment [kg]; at the outlet: per time [kg/s]
  distribution     ///< shares of the particle volume between diameters [-]
};
inline constexpr Quantity kQuantities[] = {Quantity::d10,        Quantity::d50,         Quantity::d90,
                                           Quantity::number,     Quantity::porosity,    Quantity::liquid_content,
                                           Quantity::solid_mass, Quantity::distribution};
const char* name_of(Quantity quantity);
/// As an error or a value of it is written: "m", "1", "kg"; of the outlet's rates the unit lacks its "/s".
const char* unit_of(Quantity quantity);

/// Compartment of a target: its index from 0, or one of these.
inline constexpr int kEverywhere = -1;  ///< all compartments together
inline constexpr int kOutlet = -2;      ///< what flows out of the last one

struct Target {
  std::string experiment;  ///< name of one of the problem's
  Quantity quantity = Quantity::d50;
  double time = 0.0;  ///< [s] of process time
  int compartment = kEverywhere;
  double value = 0.0;          ///< SI; unused for a distribution
  std::vector<double> edges;   ///< of the size classes, rising [m], shape (n + 1); distributions only
  std::vector<double> shares;  ///< of the volume between them [-], shape (n); what lies outside belongs to none
  double error = 0.0;          ///< standard deviation of the value, or of each share; > 0; SI
  double weight = 1.0;         ///< of its squared residual; >= 0
  bool held_out = false;       ///< only looked at: never fitted to

  /// How many numbers it is: the shares, or 1.
  std::size_t size() const { return quantity == Quantity::distribution ? shares.size() : 1; }
};

json::Value to_json(const Target& target);

}  // namespace granary::estimation
