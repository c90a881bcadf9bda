#include "dem_templates/plugin/tally/contact_book.hpp"

#include <algorithm>

namespace granary::dem {
namespace {

constexpr std::size_t kHead = 7;  // n_partners, known, velocity, bodies, axial

}  // namespace

bool ContactBook::had_partner(std::size_t particle, std::int64_t partner) const {
  const auto& partners = pages_[particle].partners;
  return std::find(partners.begin(), partners.end(), partner) != partners.end();
}

void ContactBook::forget_partners() {
  for (Page& page : pages_) page.partners.clear();
}

std::size_t ContactBook::packed_size(std::size_t particle) const { return kHead + pages_[particle].partners.size(); }

std::size_t ContactBook::pack(std::size_t particle, double* buffer) const {
  const auto& [memory, partners] = pages_[particle];
  buffer[0] = static_cast<double>(partners.size());
  buffer[1] = memory.known ? 1.0 : 0.0;
  std::copy(memory.velocity.begin(), memory.velocity.end(), buffer + 2);
  buffer[5] = static_cast<double>(memory.bodies);
  buffer[6] = memory.axial;
  std::transform(partners.begin(), partners.end(), buffer + kHead,
                 [](std::int64_t tag) { return static_cast<double>(tag); });
  return packed_size(particle);
}

std::size_t ContactBook::unpack(std::size_t particle, const double* buffer) {
  auto& [memory, partners] = pages_[particle];
  partners.resize(static_cast<std::size_t>(buffer[0]));
  memory.known = buffer[1] != 0.0;
  std::copy(buffer + 2, buffer + 5, memory.velocity.begin());
  memory.bodies = static_cast<std::uint64_t>(buffer[5]);
  memory.axial = buffer[6];
  std::transform(buffer + kHead, buffer + kHead + partners.size(), partners.begin(),
                 [](double tag) { return static_cast<std::int64_t>(tag); });
  return packed_size(particle);
}

}  // namespace granary::dem
