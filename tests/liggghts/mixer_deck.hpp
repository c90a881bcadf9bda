// Bursts in both machines, written as the controller writes them and run with real LIGGGHTS.
#pragma once

#include <cmath>
#include <string>

#include "common/units.hpp"
#include "dem_templates/render/automatic.hpp"
#include "dem_templates/render/deck.hpp"
#include "tests/liggghts/plugin_deck.hpp"

namespace granary::dem::test {

/// `n` particles of one diameter, shared between so many compartments by their volume.
inline DemCase filled(Machine machine, long n, double diameter, int n_compartments) {
  DemCase c;
  c.name = "test";
  c.machine = machine;
  const auto edges = compartment_edges(machine, n_compartments);
  const auto volumes = compartment_volume(machine, n_compartments);
  double whole = 0.0;
  for (double v : volumes) whole += v;
  for (std::size_t i = 0; i < volumes.size(); ++i)
    c.population.push_back(
        {edges[i], edges[i + 1], {diameter}, {std::lround(static_cast<double>(n) * volumes[i] / whole)}});
  c.tally.class_edges = {0.5 * diameter, 1.5 * diameter};
  c.tally.window = 0.005;
  c.time_step = 1e-5;
  c.settle_time = 0.02;
  c.duration = 0.02;
  return c;
}

inline DemCase a_mixer() { return filled(Machine{}, 300, 0.004, 4); }

inline DemCase a_bowl() {
  Machine bowl;
  bowl.type = Machine::Type::batch_bowl;
  bowl.impeller_speed = 300.0 / 60 * 2 * kPi;
  bowl.chopper_speed = 3000.0 / 60 * 2 * kPi;
  return filled(bowl, 300, 0.003, 1);
}

/// Writes the burst, adds LIGGGHTS commands before its first run, and runs it; the exit code.
inline int run_burst(const Folder& folder, const std::string& burst, const DemCase& c, const std::string& commands = "",
                     int ranks = 1) {
  const Status written = write_burst(c, folder / burst);
  if (!written) {
    ADD_FAILURE() << written.error().message;
    return -1;
  }
  std::string script = folder.read(burst + "/in.liggghts");
  script.insert(script.find("\nrun "), "\n" + commands);
  folder.write(burst + "/in.liggghts", script);
  return shell(folder,
               "cd " + burst + " && " + (ranks > 1 ? mpirun(ranks) : std::string()) + program() + " -in in.liggghts");
}

}  // namespace granary::dem::test
