#include "dem_templates/plugin/fix_agglomerates.hpp"

#include <fmt/format.h>
#include <mpi.h>

#include <algorithm>
#include <limits>
#include <numbers>

#include <atom.h>
#include <atom_vec.h>
#include <comm.h>
#include <domain.h>
#include <modify.h>

#include "dem_templates/plugin/ending.hpp"
#include "dem_templates/plugin/fix_bond.hpp"
#include "dem_templates/plugin/fix_words.hpp"
#include "dem_templates/plugin/gather.hpp"
#include "dem_templates/plugin/input/fix_arguments.hpp"
#include "dem_templates/plugin/machine_space.hpp"

namespace granary::dem {

using Range = FixArguments::Range;

FixAgglomerates::FixAgglomerates(LAMMPS_NS::LAMMPS* lammps, int narg, char** arg) : Fix(lammps, narg, arg) {
  FixArguments arguments(fix_words(narg, arg), {{"bond"},
                                                {"file"},
                                                {"pack", 3},
                                                {"count"},
                                                {"region"},
                                                {"walls", 1, true},
                                                {"mesh", 1, true},
                                                {"density"},
                                                {"type"},
                                                {"seed"},
                                                {"tries"}});
  bond_ = arguments.text("bond");
  density_ = arguments.number("density", Range::positive());
  type_ = static_cast<int>(arguments.integer_or("type", 1, Range::between(1, atom->ntypes)));
  placing_.seed = static_cast<std::uint64_t>(arguments.integer_or("seed", 1, Range::not_negative()));
  placing_.tries = static_cast<int>(arguments.integer_or("tries", placing_.tries, Range::between(1, 1e8)));
  if (arguments.has("region")) {
    space_ = arguments.text("region");
    placing_.count = static_cast<int>(arguments.integer("count", Range::between(0, 1e7)));
  } else if (arguments.has("count")) {
    arguments.problem("'count' needs a 'region' to place them in; without it they stand as in the file.");
  }
  for (const auto& walls : arguments.all("walls")) walls_.push_back(walls[0]);
  for (const auto& mesh : arguments.all("mesh")) meshes_.push_back(mesh[0]);

  if (arguments.has("file") == arguments.has("pack"))
    arguments.problem("needs the agglomerates' shape: either 'file FILE' or 'pack SPHERES SPHERE_DIAMETER DIAMETER'.");
  if (arguments.has("pack") && !arguments.has("region")) arguments.problem("'pack' needs a 'region' and a 'count'.");
  if (arguments.has("pack")) {
    const std::vector<double> asked = arguments.numbers("pack", Range::positive());
    const bool good = asked[0] >= 1.0 && asked[0] <= 1000.0 && asked[0] == std::floor(asked[0]) && asked[2] >= asked[1];
    if (!good)
      arguments.problem("'pack' needs a whole number of spheres up to 1000, and a diameter not below the spheres'.");
    else
      shapes_ = {pack_ball(static_cast<int>(asked[0]), asked[1], asked[2], placing_.seed)};
  }
  end_if_failed(world, arguments.status());
  if (!arguments.has("file")) return;
  auto read = read_agglomerates(arguments.text("file"));
  end_if_failed(world, read ? Status{} : Status(read.error()));
  shapes_ = std::move(read).value();
}

int FixAgglomerates::setmask() { return LAMMPS_NS::FixConst::PRE_EXCHANGE; }

double FixAgglomerates::max_rad(int type) {
  double largest = 0.0;
  if (type != type_) return largest;
  for (const Agglomerate& shape : shapes_)
    for (const AgglomerateSphere& sphere : shape) largest = std::max(largest, sphere.radius);
  return largest;
}

double FixAgglomerates::min_rad(int type) {
  double smallest = std::numeric_limits<double>::infinity();
  for (const Agglomerate& shape : shapes_)
    for (const AgglomerateSphere& sphere : shape) smallest = std::min(smallest, sphere.radius);
  return type == type_ ? smallest : 0.0;
}

// No ghosts are needed yet: comm->exchange() and borders() follow.
void FixAgglomerates::setup_pre_exchange() {
  if (done_) return;
  done_ = true;
  const std::vector<Agglomerate> agglomerates = placed();
  insert(agglomerates);
  std::size_t n_spheres = 0;
  for (const Agglomerate& one : agglomerates) n_spheres += one.size();
  const std::string said = fmt::format(
      "granary/agglomerates: {} agglomerates of {} spheres together; the first is {:.4g} m across, solid "
      "fraction {:.3f}\n",
      agglomerates.size(), n_spheres, agglomerate_diameter(shapes_[0]), solid_fraction(shapes_[0]));
  for (FILE* out : {screen, logfile})
    if (comm->me == 0 && out) std::fputs(said.c_str(), out);
}

Agglomerate FixAgglomerates::spheres_there() const {
  std::vector<double> mine;
  for (int i = 0; i < atom->nlocal; ++i) {
    const double* x = atom->x[i];
    mine.insert(mine.end(), {static_cast<double>(atom->tag[i]), x[0], x[1], x[2], atom->radius[i]});
  }
  const std::vector<double> all = gather_all(world, mine);
  Agglomerate there;
  for (auto v = all.begin(); v != all.end(); v += 5) there.push_back({{v[1], v[2], v[3]}, v[4]});
  return there;
}

std::vector<Agglomerate> FixAgglomerates::placed() const {
  if (space_.empty()) return shapes_;
  const Agglomerate there = spheres_there();
  double largest = 0.0;
  for (const Agglomerate& shape : shapes_)
    for (const AgglomerateSphere& sphere : shape) largest = std::max(largest, sphere.radius);
  auto space = machine_space(*lmp, space_, meshes_, walls_, largest);
  if (!space) refuse(space.error());
  auto agglomerates = place_agglomerates(shapes_, **space, there, placing_);
  if (!agglomerates) refuse(agglomerates.error());
  return std::move(agglomerates).value();
}

void FixAgglomerates::insert(const std::vector<Agglomerate>& agglomerates) {
  auto* bonds = dynamic_cast<FixBond*>(modify->find_fix_id(bond_.c_str()));
  if (!bonds) refuse(Error{"there is no fix granary/bond '" + bond_ + "'."});
  int last_tag = 0;
  for (int i = 0; i < atom->nlocal; ++i) last_tag = std::max(last_tag, atom->tag[i]);
  MPI_Allreduce(MPI_IN_PLACE, &last_tag, 1, MPI_INT, MPI_MAX, world);
  double number = bonds->largest_agglomerate();
  long asked = atom->natoms;

  for (const Agglomerate& agglomerate : agglomerates) {
    ++number;
    for (const auto& [centre, radius] : agglomerate) {
      ++last_tag;
      ++asked;
      double place[3] = {centre[0], centre[1], centre[2]};
      if (!domain->is_in_subdomain(place)) continue;
      atom->avec->create_atom(type_, place);
      const int i = atom->nlocal - 1;
      atom->tag[i] = last_tag;
      atom->mask[i] = 1 | groupbit;
      std::fill_n(atom->v[i], 3, 0.0);
      std::fill_n(atom->omega[i], 3, 0.0);
      atom->radius[i] = radius;
      atom->density[i] = density_;
      atom->rmass[i] = 4.0 / 3.0 * std::numbers::pi * radius * radius * radius * density_;
      for (int f = 0; f < modify->nfix; ++f)
        if (modify->fix[f]->create_attribute) modify->fix[f]->set_arrays(i);
      bonds->join(i, number);
    }
  }
  long got = atom->nlocal;
  MPI_Allreduce(MPI_IN_PLACE, &got, 1, MPI_LONG, MPI_SUM, world);
  if (got != asked)
    refuse(Error{fmt::format("{} of the particles lie outside the simulation box. Make the box larger.", asked - got)});
  atom->natoms = got;
  if (!atom->map_style) return;
  atom->nghost = 0;
  atom->map_init();
  atom->map_set();
}

void FixAgglomerates::refuse(const Error& why) const {
  end_program(world, static_cast<int>(why.exit),
              "fix " + std::string(id) + " (granary/agglomerates): " + why.message + " See docs/dem_styles.md.");
}

}  // namespace granary::dem
