// What is remembered of a particle goes with it, wherever it goes.
#include "dem_templates/plugin/tally/contact_book.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace granary::dem {
namespace {

constexpr std::int64_t kTag = 4, kFar = 2000000001;

ContactBook book_with_one() {
  ContactBook book;
  book.resize(3);
  for (const std::int64_t owner : {kTag + 1, kTag, kTag - 1}) book.note_pair(owner, 7);
  book.note_pair(kTag, kFar);
  book.memory(2) = {true, {1.0, 2.0, 3.0}, (std::uint64_t{1} << (kMostBodies - 1)) | 5, 0.5};
  return book;
}

void expect_same(ContactBook& book, std::size_t particle) {
  EXPECT_TRUE(book.touched(kTag, 7));
  EXPECT_TRUE(book.touched(kTag, kFar));
  EXPECT_FALSE(book.touched(kTag, 8));
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
  ContactBook here = book_with_one();
  std::vector<double> buffer(here.largest_packed(), -1.0);
  EXPECT_EQ(here.pack(2, kTag, buffer.data()), buffer.size());
  EXPECT_EQ(buffer.size(), 9u);

  ContactBook there;
  there.resize(2);
  there.note_pair(kTag, 99);
  there.forget_pairs();
  EXPECT_EQ(there.unpack(1, kTag, buffer.data()), buffer.size());
  expect_same(there, 1);
  EXPECT_FALSE(there.touched(kTag, 99));
  EXPECT_FALSE(there.touched(kTag + 1, 7));
}

TEST(ContactBook, KnowsNothingOfAParticleThatIsNew) {
  ContactBook book = book_with_one();
  book.clear(2);
  EXPECT_FALSE(book.memory(2).known);
  EXPECT_EQ(book.memory(2).bodies, 0u);
  EXPECT_TRUE(std::isnan(book.memory(2).axial));
}

TEST(ContactBook, KeepsItsMemoriesWhenItForgetsPairs) {
  ContactBook book = book_with_one();
  book.forget_pairs();
  EXPECT_FALSE(book.touched(kTag, 7));
  EXPECT_TRUE(book.memory(2).known);
}

TEST(ContactBook, KnowsPairsThatArriveAmongThoseItHas) {
  ContactBook book = book_with_one();
  EXPECT_TRUE(book.touched(kTag + 1, 7));
  book.note_pair(1, 2);
  EXPECT_TRUE(book.touched(1, 2));
  EXPECT_TRUE(book.touched(kTag + 1, 7));
}

TEST(ContactBook, TellsThousandsOfPairsFromOthers) {
  ContactBook book;
  for (int round = 0; round < 2; ++round) {
    EXPECT_FALSE(book.touched(1, 2));
    for (std::int64_t owner = 1; owner <= 3000; ++owner) book.note_pair(owner, owner + 1 + owner % 7);
    for (std::int64_t owner = 1; owner <= 3000; ++owner)
      for (std::int64_t off = 1; off <= 8; ++off)
        EXPECT_EQ(book.touched(owner, owner + off), off == 1 + owner % 7) << owner << " " << off;
    book.forget_pairs();
  }
}

}  // namespace
}  // namespace granary::dem
