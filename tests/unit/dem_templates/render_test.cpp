#include "dem_templates/render/render.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>

namespace granary::dem {
namespace {

using testing::AllOf;
using testing::HasSubstr;

std::string refused(std::string_view text, const Values& values) {
  const auto filled = render(text, "in.test.tmpl", values);
  EXPECT_FALSE(filled) << *filled;
  return filled ? "" : filled.error().message;
}

TEST(Render, PutsEveryValueInItsPlaces) {
  const auto filled = render("run @{n}\n# @{n} of @{what}{}@\n", "t", {{"what", "@{n}"}, {"n", "5"}});
  ASSERT_TRUE(filled);
  EXPECT_EQ(*filled, "run 5\n# 5 of @{n}{}@\n");  // a value is put in as it is
}

TEST(Render, APlaceholderWithoutAValueIsAnErrorThatNamesIt) {
  EXPECT_THAT(refused("units si\ntimestep @{time_step}\n", {}),
              AllOf(HasSubstr("in.test.tmpl"), HasSubstr("line 2"), HasSubstr("@{time_step}")));
}

TEST(Render, AValueWithoutAPlaceholderIsAnErrorThatNamesIt) {
  EXPECT_THAT(refused("units si\n", {{"skin", "0.002"}}), AllOf(HasSubstr("in.test.tmpl"), HasSubstr("skin")));
}

TEST(Render, AValueGivenTwiceIsAnError) { EXPECT_THAT(refused("@{n}", {{"n", "1"}, {"n", "2"}}), HasSubstr("twice")); }

TEST(Render, APlaceholderThatIsNotClosedIsAnError) {
  EXPECT_THAT(refused("a\nrun @{n\n}", {{"n", "1"}}), AllOf(HasSubstr("line 2"), HasSubstr("closing brace")));
}

TEST(Render, NumbersReadBackToTheSameBits) {
  for (double x : {1.0 / 3.0, 1e-5, 209.43951023931953, 8e6, 5e-324})
    EXPECT_EQ(std::strtod(digits(x).c_str(), nullptr), x) << digits(x);
}

}  // namespace
}  // namespace granary::dem
