// main() of the test programs. `PROGRAM NAME` runs the tests of NAME.cpp alone: a program holds those of many files.
#include <gmock/gmock.h>

#include <cstdio>
#include <filesystem>
#include <string>

namespace {

/// What --gtest_filter must be for the tests of one file; empty: it has none.
std::string tests_of(const std::string& name) {
  std::string filter;
  const auto& all = *testing::UnitTest::GetInstance();
  for (int s = 0; s < all.total_test_suite_count(); ++s) {
    const auto& suite = *all.GetTestSuite(s);
    for (int t = 0; t < suite.total_test_count(); ++t) {
      const auto& test = *suite.GetTestInfo(t);
      if (std::filesystem::path(test.file()).stem() == name)
        filter += std::string(suite.name()) + "." + test.name() + ":";
    }
  }
  return filter;
}

}  // namespace

int main(int argc, char** argv) {
  testing::InitGoogleMock(&argc, argv);
  if (argc > 1) {
    const std::string filter = tests_of(argv[1]);
    if (filter.empty()) return std::fprintf(stderr, "there are no tests of %s.cpp in here\n", argv[1]), 2;
    testing::GTEST_FLAG(filter) = filter;
  }
  return RUN_ALL_TESTS();
}
