#include "controller/bench/dem_deck.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <sstream>

#include "common/files.hpp"
#include "common/units.hpp"
#include "controller/bench/dem_cases.hpp"
#include "controller/bench/dem_run.hpp"
#include "dem_templates/geometry/machine.hpp"
#include "dem_templates/render/deck.hpp"
#include "dem_templates/render/wall_commands.hpp"

namespace granary::bench {
namespace {

namespace fs = std::filesystem;

constexpr const char* kDump = R"(
unfix tally
dump state all custom 1 state.dump id diameter density x y z vx vy vz omegax omegay omegaz
dump_modify state sort id format "%d %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g"
run 0
)";

/// A dump of columns id diameter density x y z vx vy vz omegax omegay omegaz as a data file.
Result<std::string> data_file(const std::string& dump, const dem::Box3& box, long& particles) {
  std::istringstream lines(dump);
  std::string atoms, velocities;
  bool rows = false;
  for (std::string line; std::getline(lines, line);) {
    if (line.rfind("ITEM: ", 0) == 0) {
      rows = line.rfind("ITEM: ATOMS", 0) == 0;
      continue;
    }
    if (!rows) continue;
    std::istringstream words(line);
    std::vector<std::string> word;
    for (std::string one; words >> one;) word.push_back(one);
    if (word.size() != 12)
      return Error{fmt::format("state.dump: not the line of a particle: {}", line), Exit::internal};
    atoms += fmt::format("{} 1 {}\n", word[0], fmt::join(word.begin() + 1, word.begin() + 6, " "));
    velocities += fmt::format("{} {}\n", word[0], fmt::join(word.begin() + 6, word.end(), " "));
    ++particles;
  }
  return fmt::format(
      "settled state\n\n{} atoms\n2 atom types\n\n{} {} xlo xhi\n{} {} ylo yhi\n{} {} zlo zhi\n\nAtoms\n\n{}\n"
      "Velocities\n\n{}",
      particles, box.low.x, box.high.x, box.low.y, box.high.y, box.low.z, box.high.z, atoms, velocities);
}

std::string tally_commands(const dem::DemCase& c, const std::vector<dem::Body>& all, long steps, int windows) {
  std::vector<double> edges{c.population.front().from};
  for (const dem::Population& p : c.population) edges.push_back(p.to);
  const long window = std::max(1L, steps / windows / c.tally.every) * c.tally.every;
  return fmt::format(
      "fix tally all granary/tally file tallies.jsonl every {} window {} axis {} compartments {} {} classes {} {}{}\n",
      c.tally.every, window, c.machine.type == dem::Machine::Type::cm5 ? "x" : "z", c.population.size(),
      fmt::join(edges, " "), c.tally.class_edges.size() - 1, fmt::join(c.tally.class_edges, " "),
      dem::tally_bodies(c, all));
}

}  // namespace

Result<State> settled_state(const dem::DemCase& asked, int turns, const fs::path& folder) {
  dem::DemCase c = asked;
  c.walls = dem::Walls::granary;
  // The fill is all settling but for the last turn; both end at whole turns, where the blades stand as in their mesh.
  c.settle_time = (turns - 1) * turn_of(c);
  c.duration = c.tally.window = turn_of(c);
  GRANARY_TRY(const Burst burst, run_burst(c, folder, kDump));
  GRANARY_TRY(const std::vector<dem::Body> all, dem::bodies(c.machine));
  GRANARY_TRY(const std::string dump, read_text(folder / "state.dump"));
  State state{folder, 0};
  GRANARY_TRY(const std::string data, data_file(dump, dem::simulation_box(all), state.particles));
  GRANARY_CHECK(write_text_atomically(folder / "state.data", data));
  return state;
}

Result<std::string> timing_deck(const dem::DemCase& asked, const TimingDeck& deck) {
  dem::DemCase c = asked;
  c.walls = deck.walls;
  GRANARY_TRY(const std::vector<dem::Body> all, dem::bodies(c.machine));
  GRANARY_TRY(std::string walls, dem::wall_commands(c, all));
  if (deck.windows > 0) walls += dem::watching_walls(c, all);
  const dem::Contact& m = c.contact;
  const auto pairs = [](double value) { return fmt::format("{0} {0} {0} {0}", value); };
  const auto down = dem::gravity_direction(c.machine);
  std::string text = fmt::format(
      "atom_style granular\natom_modify map array\nboundary f f f\nnewton off\ncommunicate single vel yes\nunits si\n"
      "processors {} 1 1\nread_data state.data\nneighbor {} bin\nneigh_modify delay 0\n"
      "fix m1 all property/global youngsModulus peratomtype {} {}\n"
      "fix m2 all property/global poissonsRatio peratomtype {} {}\n"
      "fix m3 all property/global coefficientRestitution peratomtypepair 2 {}\n"
      "fix m4 all property/global coefficientFriction peratomtypepair 2 {}\n"
      "pair_style gran model hertz tangential history\npair_coeff * *\ntimestep {}\n"
      "fix gravity all gravity {} vector {} {} {}\nfix integrate all nve/sphere\n{}\n"
      "thermo 1000000\nthermo_modify lost ignore norm no\nrun {}\n",
      c.ranks, deck.skin.value_or(c.tally.class_edges.back() / 4.0), m.young_modulus, m.wall_young_modulus,
      m.poisson_ratio, m.poisson_ratio, pairs(m.restitution), pairs(m.friction), c.time_step, kGravity, down.x, down.y,
      down.z, walls, deck.warm_up);
  if (!deck.skin) text += dem::skin_trial(c);
  if (deck.windows > 0) text += tally_commands(c, all, deck.steps, deck.windows);
  return text + fmt::format("run {}\n", deck.steps);
}

}  // namespace granary::bench
