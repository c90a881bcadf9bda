// A contact counts when it begins, once; wherever its particle goes.
#include "dem_templates/plugin/tally/contact_book.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace granary::dem {
namespace {

ContactBook book_of(std::size_t n) {
  ContactBook book;
  book.resize(n);
  return book;
}

TEST(ContactBook, CountsAContactOnceWhileItLasts) {
  ContactBook book = book_of(1);
  int began = 0;
  for (int look = 0; look < 10; ++look) {
    book.begin_look();
    began += book.touches(0, 7, 1.0).began;
  }
  EXPECT_EQ(began, 1);
}

TEST(ContactBook, CountsAgainAfterALookWithoutTouch) {
  ContactBook book = book_of(1);
  book.begin_look();
  EXPECT_TRUE(book.touches(0, 7, 1.0).began);
  book.begin_look();
  book.begin_look();
  EXPECT_TRUE(book.touches(0, 7, 1.0).began);
}

TEST(ContactBook, TakesSeveralTouchesInOneLookAsOne) {
  ContactBook book = book_of(1);
  book.begin_look();
  EXPECT_TRUE(book.touches(0, body_partner(2), 1.0).began);
  EXPECT_FALSE(book.touches(0, body_partner(2), 1.0).began);
  EXPECT_TRUE(book.touches(0, body_partner(1), 1.0).began);
}

TEST(ContactBook, GivesTheSpeedOfTheApproachSeenOneLookBefore) {
  ContactBook book = book_of(1);
  book.begin_look();
  book.approaches(0, 7, 3.0);
  book.begin_look();
  const auto touch = book.touches(0, 7, 2.5);
  EXPECT_TRUE(touch.began);
  EXPECT_DOUBLE_EQ(touch.speed, 3.0);

  book.approaches(0, 8, 4.0);
  book.begin_look();
  book.begin_look();
  EXPECT_DOUBLE_EQ(book.touches(0, 8, 2.5).speed, 2.5);  // two looks ago is too long ago
}

TEST(ContactBook, GoesOnAfterAParticleIsRenumberedAndSentToAnotherRank) {
  ContactBook here = book_of(3), there = book_of(1);
  here.begin_look();
  there.begin_look();
  here.touches(2, 7, 1.0);
  here.approaches(2, 8, 2.0);
  here.memory(2) = {true, {1.0, 2.0, 3.0}, 0.5};

  here.copy(2, 0);
  std::vector<double> buffer(here.packed_size(0));
  EXPECT_EQ(here.pack(0, buffer.data()), buffer.size());
  EXPECT_EQ(there.unpack(0, buffer.data()), buffer.size());

  there.begin_look();
  EXPECT_FALSE(there.touches(0, 7, 1.0).began);
  EXPECT_DOUBLE_EQ(there.touches(0, 8, 9.0).speed, 2.0);
  EXPECT_TRUE(there.memory(0).known);
  EXPECT_DOUBLE_EQ(there.memory(0).velocity[2], 3.0);
  EXPECT_DOUBLE_EQ(there.memory(0).axial, 0.5);
}

TEST(ContactBook, KnowsNothingOfAClearedParticle) {
  ContactBook book = book_of(1);
  book.begin_look();
  book.touches(0, 7, 1.0);
  book.memory(0).known = true;
  book.clear(0);
  EXPECT_FALSE(book.memory(0).known);
  EXPECT_TRUE(book.touches(0, 7, 1.0).began);
}

TEST(ContactBook, DoesNotGrowWithEveryPartnerEverMet) {
  ContactBook book = book_of(1);
  for (int look = 0; look < 1000; ++look) {
    book.begin_look();
    book.touches(0, look + 1, 1.0);
  }
  EXPECT_LE(book.packed_size(0), 6u + 2u * 4u);
}

}  // namespace
}  // namespace granary::dem
