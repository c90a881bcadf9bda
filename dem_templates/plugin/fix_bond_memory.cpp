// What granary/bond keeps with the particles, in restart files, and sends between ranks.
#include <mpi.h>

#include <algorithm>

#include <atom.h>
#include <comm.h>

#include "dem_templates/plugin/fix_bond.hpp"

namespace granary::dem {
// Of a new fix LIGGGHTS would clear all particles' pages after this, also of those that just joined an agglomerate.
void FixBond::setup_pre_exchange() {
  just_created = false;
  pre_exchange();
}

void FixBond::pre_exchange() {
  rows_to_book();
  std::size_t largest = 0;
  for (int i = 0; i < atom->nlocal; ++i) largest = std::max(largest, book_.packed_size(static_cast<std::size_t>(i)));
  comm->maxexchange_fix = std::max(comm->maxexchange_fix, static_cast<int>(largest));
}

void FixBond::grow_arrays(int n) { book_.resize(static_cast<std::size_t>(n)); }
void FixBond::copy_arrays(int from, int to, int) {
  rows_to_book();
  book_.copy(static_cast<std::size_t>(from), static_cast<std::size_t>(to));
}
void FixBond::set_arrays(int particle) { book_.clear(static_cast<std::size_t>(particle)); }

int FixBond::pack_exchange(int particle, double* buffer) {
  return static_cast<int>(book_.pack(static_cast<std::size_t>(particle), buffer));
}
int FixBond::unpack_exchange(int particle, double* buffer) {
  return static_cast<int>(book_.unpack(static_cast<std::size_t>(particle), buffer));
}

// LIGGGHTS wants the length first.
int FixBond::pack_restart(int particle, double* buffer) {
  rows_to_book();
  buffer[0] = static_cast<double>(size_restart(particle));
  book_.pack(static_cast<std::size_t>(particle), buffer + 1);
  return size_restart(particle);
}

// Our values come after those of nth other fixes.
void FixBond::unpack_restart(int particle, int nth) {
  const double* values = atom->extra[particle];
  for (int k = 0; k < nth; ++k) values += static_cast<int>(values[0]);
  book_.unpack(static_cast<std::size_t>(particle), values + 1);
}

int FixBond::size_restart(int particle) {
  return 1 + static_cast<int>(book_.packed_size(static_cast<std::size_t>(particle)));
}

int FixBond::maxsize_restart() {
  int largest = 1 + static_cast<int>(BondBook::kLeastPacked);
  for (int i = 0; i < atom->nlocal; ++i) largest = std::max(largest, size_restart(i));
  return largest;
}

// What broke since the last look is told first: whoever goes on from this state will not hear of it.
void FixBond::write_restart(FILE* file) {
  if (watching()) tell_breaks();
  double sums[2] = {broken_here_, released_here_};
  MPI_Allreduce(MPI_IN_PLACE, sums, 2, MPI_DOUBLE, MPI_SUM, world);
  if (comm->me != 0) return;
  std::vector<double> state{grouped_ ? 1.0 : 0.0, sums[0], sums[1]};
  const std::vector<double> history = history_.state();
  state.insert(state.end(), history.begin(), history.end());
  const int size = static_cast<int>(state.size() * sizeof(double));
  fwrite(&size, sizeof size, 1, file);
  fwrite(state.data(), sizeof(double), state.size(), file);
}

void FixBond::restart(char* state) {
  const auto* values = reinterpret_cast<const double*>(state);
  grouped_ = values[0] > 0.0;
  if (comm->me != 0) return;  // rank 0 goes on with the sums of all
  broken_here_ = values[1];
  released_here_ = values[2];
  history_.set_state(values + 3);
}

// ---- between ranks ----

int FixBond::pack_comm(int n, int* list, double* buffer, int, int*) {
  for (int k = 0; k < n; ++k) {
    *buffer++ = agglomerate_[static_cast<std::size_t>(list[k])];
    *buffer++ = waiting_[static_cast<std::size_t>(list[k])];
  }
  return 2;
}

void FixBond::unpack_comm(int n, int first, double* buffer) {
  for (int k = first; k < first + n; ++k) {
    agglomerate_[static_cast<std::size_t>(k)] = *buffer++;
    waiting_[static_cast<std::size_t>(k)] = *buffer++;
  }
}

int FixBond::pack_reverse_comm(int n, int first, double* buffer) {
  std::copy_n(numbers_.data() + static_cast<std::size_t>(first) * n_numbers_, static_cast<std::size_t>(n) * n_numbers_,
              buffer);
  return static_cast<int>(n_numbers_);
}

void FixBond::unpack_reverse_comm(int n, int* list, double* buffer) {
  for (int k = 0; k < n; ++k)
    for (std::size_t m = 0; m < n_numbers_; ++m)
      numbers_[static_cast<std::size_t>(list[k]) * n_numbers_ + m] += *buffer++;
}

}  // namespace granary::dem
