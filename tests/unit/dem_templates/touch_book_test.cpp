// What particles remember of their touches with bodies.
#include "dem_templates/plugin/wall/touch_book.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <vector>

namespace granary::dem {
namespace {

SurfaceTouch touch(const Vector3& normal) { return {.normal = (1.0 / norm(normal)) * normal}; }

/// Touches of body 3 along x and y and of body 4 along z, each with a history of its own.
TouchBook::Page a_page() {
  TouchBook::Page page;
  std::array<std::size_t, 2> slot{};
  const std::vector<SurfaceTouch> of_3{touch({1, 0, 0}), touch({0, 1, 0})}, of_4{touch({0, 0, 1})};
  EXPECT_FALSE(page.go_on(3, of_3, slot.data()));
  EXPECT_FALSE(page.go_on(4, of_4, slot.data()));
  for (std::size_t k = 0; k < page.n; ++k) {
    page.place[k].shear = {1.0 + static_cast<double>(k), 0.0, 0.0};
    page.rolling[k] = {0.0, 1.0 + static_cast<double>(k), 0.0};
  }
  EXPECT_EQ(page.n, 3u);
  return page;
}

TEST(TouchBook, ATouchThatHasTurnedALittleGoesOnWithItsHistory) {
  TouchBook::Page page = a_page();
  std::array<std::size_t, 2> slot{};
  const std::vector<SurfaceTouch> now{touch({0.1, 1, 0}), touch({1, 0.1, 0})};  // the other one is the nearer now
  EXPECT_TRUE(page.go_on(3, now, slot.data()));
  ASSERT_EQ(page.n, 3u);
  EXPECT_EQ(page.place[slot[0]].shear[0], 2.0);
  EXPECT_EQ(page.place[slot[1]].shear[0], 1.0);
  EXPECT_EQ(page.rolling[slot[0]][1], 2.0);
  EXPECT_EQ(page.place[slot[0]].normal, now[0].normal);
  EXPECT_EQ(page.place[slot[1]].normal, now[1].normal);
}

TEST(TouchBook, ATouchThatEndsIsForgottenAndTheOthersKeepTheirs) {
  TouchBook::Page page = a_page();
  std::array<std::size_t, 2> slot{};
  const std::vector<SurfaceTouch> now{touch({0, 1, 0})};
  EXPECT_TRUE(page.go_on(3, now, slot.data()));
  ASSERT_EQ(page.n, 2u);
  EXPECT_EQ(page.place[slot[0]].shear[0], 2.0);
  const std::vector<SurfaceTouch> of_4{touch({0, 0, 1})};
  EXPECT_TRUE(page.go_on(4, of_4, slot.data()));
  EXPECT_EQ(page.place[slot[0]].shear[0], 3.0);
  page.forget(4);
  EXPECT_FALSE(page.go_on(4, of_4, slot.data()));
  EXPECT_EQ(page.place[slot[0]].shear[0], 0.0);
  EXPECT_EQ(page.rolling[slot[0]][1], 0.0);
}

TEST(TouchBook, ATouchElsewhereBeginsAnew) {
  TouchBook::Page page = a_page();
  std::array<std::size_t, 2> slot{};
  const std::vector<SurfaceTouch> now{touch({-1, 0, 0})};
  EXPECT_TRUE(page.go_on(3, now, slot.data()));
  EXPECT_EQ(page.n, 2u);
  EXPECT_EQ(page.place[slot[0]].shear[0], 0.0);
}

TEST(TouchBook, WhatFindsNoPlaceOnAFullPageSaysSo) {
  TouchBook::Page page = a_page();
  std::vector<SurfaceTouch> now;
  for (const double x : {-1.0, 1.0})
    for (const Vector3& n : {Vector3{x, 0, 0}, Vector3{0, x, 0}, Vector3{0, 0, x}}) now.push_back(touch(n));
  std::vector<std::size_t> slot(now.size());
  EXPECT_FALSE(page.go_on(7, now, slot.data()));
  EXPECT_EQ(page.n, TouchBook::kMost);
  EXPECT_EQ(std::count(slot.begin(), slot.end(), TouchBook::kMost), 3);
  const std::vector<SurfaceTouch> none;
  EXPECT_TRUE(page.go_on(7, none, slot.data()));
  EXPECT_EQ(page.n, 3u);
}

TEST(TouchBook, GoesToAnotherRankAsItIs) {
  TouchBook book;
  book.resize(2);
  book.page(0) = a_page();
  std::vector<double> buffer(TouchBook::kMostPacked);
  EXPECT_EQ(book.pack(0, buffer.data()), book.packed_size(0));
  EXPECT_EQ(book.unpack(1, buffer.data()), book.packed_size(0));
  const TouchBook::Page &sent = book.page(0), &come = book.page(1);
  ASSERT_EQ(come.n, sent.n);
  EXPECT_EQ(come.body, sent.body);
  for (std::size_t k = 0; k < sent.n; ++k) {
    EXPECT_EQ(come.place[k].normal, sent.place[k].normal);
    EXPECT_EQ(come.place[k].shear, sent.place[k].shear);
    EXPECT_EQ(come.rolling[k], sent.rolling[k]);
  }
}

}  // namespace
}  // namespace granary::dem
