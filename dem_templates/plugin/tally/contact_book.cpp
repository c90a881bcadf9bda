#include "dem_templates/plugin/tally/contact_book.hpp"

#include <algorithm>

namespace granary::dem {
namespace {

constexpr std::size_t kHead = 6;        // n_contacts, known, velocity, axial
constexpr std::size_t kEach = 4;        // partner, look, speed, touching

}  // namespace

ContactBook::Touch ContactBook::touches(std::size_t owner, Partner partner, double speed) {
  Contact& contact = note(pages_[owner], partner);
  const bool known = remembered(contact);
  const Touch touch{!(known && contact.touching), known && !contact.touching ? contact.speed : speed};
  contact.look = look_;
  contact.touching = true;
  return touch;
}

void ContactBook::approaches(std::size_t owner, Partner partner, double speed) {
  Contact& contact = note(pages_[owner], partner);
  contact.look = look_;
  contact.speed = speed;
  contact.touching = false;
}

ContactBook::Contact& ContactBook::note(Page& page, Partner partner) {
  Contact* free = nullptr;
  for (Contact& contact : page.contacts) {
    if (contact.partner == partner) return contact;
    if (!remembered(contact)) free = &contact;
  }
  if (!free) free = &page.contacts.emplace_back();
  *free = {partner, 0, 0.0, false};
  return *free;
}

std::size_t ContactBook::packed_size(std::size_t particle) const {
  const auto& contacts = pages_[particle].contacts;
  return kHead + kEach * static_cast<std::size_t>(std::count_if(contacts.begin(), contacts.end(),
                                                                [&](const Contact& c) { return remembered(c); }));
}

std::size_t ContactBook::pack(std::size_t particle, double* buffer) const {
  const Page& page = pages_[particle];
  double* next = buffer + kHead;
  for (const Contact& contact : page.contacts) {
    if (!remembered(contact)) continue;
    *next++ = static_cast<double>(contact.partner);
    *next++ = static_cast<double>(contact.look);
    *next++ = contact.speed;
    *next++ = contact.touching ? 1.0 : 0.0;
  }
  const Memory& memory = page.memory;
  const auto packed = static_cast<std::size_t>(next - buffer);
  buffer[0] = static_cast<double>((packed - kHead) / kEach);
  buffer[1] = memory.known ? 1.0 : 0.0;
  std::copy(memory.velocity.begin(), memory.velocity.end(), buffer + 2);
  buffer[5] = memory.axial;
  return packed;
}

std::size_t ContactBook::unpack(std::size_t particle, const double* buffer) {
  Page& page = pages_[particle];
  const auto n = static_cast<std::size_t>(buffer[0]);
  page.memory.known = buffer[1] != 0.0;
  std::copy(buffer + 2, buffer + 5, page.memory.velocity.begin());
  page.memory.axial = buffer[5];
  page.contacts.clear();
  const double* next = buffer + kHead;
  for (std::size_t i = 0; i < n; ++i, next += kEach)
    page.contacts.push_back({static_cast<Partner>(next[0]), static_cast<std::uint64_t>(next[1]), next[2], next[3] != 0.0});
  return kHead + kEach * n;
}

}  // namespace granary::dem
