// What granary/wall remembers, as it follows the particles from rank to rank and through restart files.
#include <algorithm>

#include <atom.h>
#include <comm.h>

#include "dem_templates/plugin/ending.hpp"
#include "dem_templates/plugin/wall/fix_wall.hpp"
#include "dem_templates/plugin/wall/wall_state.hpp"

namespace granary::dem {

void FixWall::grow_arrays(int n) {
  book_.resize(static_cast<std::size_t>(n));
  for (Watch& watch : watches_) watch.resize(static_cast<std::size_t>(n));
}
void FixWall::copy_arrays(int from, int to, int) {
  book_.copy(static_cast<std::size_t>(from), static_cast<std::size_t>(to));
  for (Watch& watch : watches_) watch.copy(static_cast<std::size_t>(from), static_cast<std::size_t>(to));
}
void FixWall::forget_looks(int particle) {
  for (Watch& watch : watches_) watch.forget(static_cast<std::size_t>(particle));
}

void FixWall::set_arrays(int particle) {
  book_.clear(static_cast<std::size_t>(particle));
  forget_looks(particle);
}

int FixWall::pack_exchange(int particle, double* buffer) {
  return static_cast<int>(book_.pack(static_cast<std::size_t>(particle), buffer));
}

int FixWall::unpack_exchange(int particle, double* buffer) {
  forget_looks(particle);
  return static_cast<int>(book_.unpack(static_cast<std::size_t>(particle), buffer));
}

// LIGGGHTS wants the length first.
int FixWall::pack_restart(int particle, double* buffer) {
  buffer[0] = static_cast<double>(size_restart(particle));
  book_.pack(static_cast<std::size_t>(particle), buffer + 1);
  return size_restart(particle);
}

// Our values come after those of nth other fixes.
void FixWall::unpack_restart(int particle, int nth) {
  forget_looks(particle);
  const double* values = atom->extra[particle];
  for (int k = 0; k < nth; ++k) values += static_cast<int>(values[0]);
  book_.unpack(static_cast<std::size_t>(particle), values + 1);
}

int FixWall::size_restart(int particle) {
  return 1 + static_cast<int>(book_.packed_size(static_cast<std::size_t>(particle)));
}

int FixWall::maxsize_restart() { return 1 + static_cast<int>(TouchBook::kMostPacked); }

void FixWall::write_restart(FILE* file) {
  std::vector<Wear> wear;
  for (std::size_t b = 0; b < wear_.size(); ++b) wear.push_back(wear_of_all_ranks(b));
  if (comm->me != 0) return;
  const std::string state = wall_state(bodies_, wear);
  const int size = static_cast<int>(state.size() + 1);
  fwrite(&size, sizeof size, 1, file);
  fwrite(state.c_str(), 1, state.size() + 1, file);
}

void FixWall::restart(char* state) {
  const Status same = set_wall_state(state, bodies_, wear_);
  if (!same) end_if_failed(world, Error{"fix " + std::string(id) + " (granary/wall): " + same.error().message});
  if (comm->me != 0)
    for (Wear& wear : wear_) wear = Wear(wear.by_sliding.size());  // rank 0 goes on with that of all
}

}  // namespace granary::dem
