// What is remembered of a particle goes with it, wherever it goes.
#include "dem_templates/plugin/tally/contact_book.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace granary::dem {
namespace {

ContactBook book_with_one() {
  ContactBook book;
  book.resize(3);
  book.note_partner(2, 7);
  book.note_partner(2, 2000000001);
  book.memory(2) = {true, {1.0, 2.0, 3.0}, (std::uint64_t{1} << (kMostBodies - 1)) | 5, 0.5};
  return book;
}

void expect_same(ContactBook& book, std::size_t particle) {
  EXPECT_TRUE(book.had_partner(particle, 7));
  EXPECT_TRUE(book.had_partner(particle, 2000000001));
  EXPECT_FALSE(book.had_partner(particle, 8));
  EXPECT_TRUE(book.memory(particle).known);
  EXPECT_EQ(book.memory(particle).velocity[2], 3.0);
  EXPECT_EQ(book.memory(particle).bodies, (std::uint64_t{1} << (kMostBodies - 1)) | 5);
  EXPECT_EQ(book.memory(particle).axial, 0.5);
}

TEST(ContactBook, FollowsAParticleThatIsRenumbered) {
  ContactBook book = book_with_one();
  book.copy(2, 0);
  book.clear(2);
  expect_same(book, 0);
}

TEST(ContactBook, FollowsAParticleToAnotherRank) {
  const ContactBook here = book_with_one();
  std::vector<double> buffer(here.packed_size(2), -1.0);
  EXPECT_EQ(here.pack(2, buffer.data()), buffer.size());

  ContactBook there;
  there.resize(2);
  there.note_partner(1, 99);
  EXPECT_EQ(there.unpack(1, buffer.data()), buffer.size());
  expect_same(there, 1);
  EXPECT_FALSE(there.had_partner(1, 99));
}

TEST(ContactBook, KnowsNothingOfAParticleThatIsNew) {
  ContactBook book = book_with_one();
  book.clear(2);
  EXPECT_FALSE(book.memory(2).known);
  EXPECT_FALSE(book.had_partner(2, 7));
  EXPECT_EQ(book.memory(2).bodies, 0u);
  EXPECT_TRUE(std::isnan(book.memory(2).axial));
}

TEST(ContactBook, KeepsItsMemoriesWhenItForgetsPartners) {
  ContactBook book = book_with_one();
  book.forget_partners();
  EXPECT_FALSE(book.had_partner(2, 7));
  EXPECT_TRUE(book.memory(2).known);
}

}  // namespace
}  // namespace granary::dem
