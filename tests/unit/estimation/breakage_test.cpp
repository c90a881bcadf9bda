// Rates and daughters from fragment histories of known rate and daughters.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "common/json/io.hpp"
#include "estimation/breakage/daughters.hpp"
#include "estimation/breakage/history.hpp"
#include "estimation/breakage/selection_law.hpp"

namespace granary::estimation {
namespace {

/// Fragments that are split at the rate `rate(size)`, each into two with any number of spheres alike: event by event,
/// seen every `every` seconds. What is split and split again between two samples is seen as one split into three.
template <class RateOf>
FragmentHistory simulated(const RateOf& rate, int agglomerates, int spheres, double duration, double every,
                          unsigned seed) {
  std::mt19937_64 dice(seed);
  std::exponential_distribution<double> waits(1.0);
  FragmentHistory history;
  std::vector<int> alive(static_cast<std::size_t>(agglomerates), spheres);
  const auto sample = [&](double time) {
    history.push_back({time, {}, {}});
    for (const int size : alive) ++history.back().alive[size];
  };
  sample(0.0);
  for (double time = every; time < duration * (1.0 + 1e-9); time += every) {
    std::vector<int> next;
    std::vector<Split> splits;
    for (const int parent : alive) {
      std::vector<std::pair<int, double>> open{{parent, every}};  // size, time left
      std::vector<int> pieces;
      while (!open.empty()) {
        const auto [size, left] = open.back();
        open.pop_back();
        const double wait = size > 1 ? waits(dice) / rate(size) : 2.0 * left;
        if (wait >= left) {
          pieces.push_back(size);
          continue;
        }
        const int one = std::uniform_int_distribution<int>(1, size - 1)(dice);
        open.push_back({one, left - wait});
        open.push_back({size - one, left - wait});
      }
      if (pieces.size() > 1) splits.push_back({parent, pieces, parent % 2 == 0 ? "chopper" : "impeller"});
      next.insert(next.end(), pieces.begin(), pieces.end());
    }
    alive = next;
    sample(time);
    history.back().splits = splits;
  }
  return history;
}

double power_law(int size) { return 0.8 * std::pow(size / 37.0, 0.7); }

TEST(BreakageRates, OfAKnownLawLieInTheirIntervals) {
  const FragmentHistory history = simulated(power_law, 300, 37, 2.0, 0.05, 7);

  int inside = 0, all = 0;
  for (const SizeRecord& record : records_of(history, size_bounds(37))) {
    const long n = record.all_splits();
    if (n < 10) continue;
    const Rate rate = rate_of(n, record.exposure);
    const double known = 0.8 * std::pow(record.mean_size / 37.0, 0.7);
    ++all;
    inside += rate.low <= known && known <= rate.high;
  }
  EXPECT_GE(all, 8);
  EXPECT_GE(inside, all - 1);  // one in twenty may lie outside
}

TEST(BreakageRates, DoNotDependOnHowOftenOneLooks) {
  // At 3 per second and 0.2 s between samples nearly half of all are split in between; splits / time would be 25 %
  // short.
  const FragmentHistory history = simulated([](int) { return 3.0; }, 4000, 2, 0.6, 0.2, 11);

  const SizeRecord record = records_of(history, {2, 3}).front();
  const Rate rate = rate_of(record.all_splits(), record.exposure);

  EXPECT_NEAR(rate.value, 3.0, 0.1);
  EXPECT_LT(rate.low, 3.0);
  EXPECT_GT(rate.high, 3.0);
}

TEST(BreakageRates, OfAgglomeratesByThemselvesAddUpToThoseOfAll) {
  // Two of 4 spheres: the second is halved, then a half of it again.
  const FragmentHistory history{{0.0, {{4, 2}}, {}},
                                {0.1, {{4, 1}, {2, 2}}, {{4, {2, 2}, "chopper", 2}}},
                                {0.2, {{4, 1}, {2, 1}, {1, 2}}, {{2, {1, 1}, "shell", 2}}},
                                {0.3, {{4, 1}, {2, 1}, {1, 2}}, {}}};
  const std::vector<int> bounds = size_bounds(4);

  const auto apart = by_agglomerate(history, 4);

  ASSERT_EQ(apart.size(), 2u);
  EXPECT_TRUE(apart[0].back().alive == (std::map<int, long>{{4, 1}}));
  EXPECT_TRUE(apart[1].back().alive == (std::map<int, long>{{2, 1}, {1, 2}}));
  std::vector<SizeSums> sums(bounds.size() - 1);
  for (const FragmentHistory& one : apart)
    for (std::size_t c = 0; c < sums.size(); ++c) sums[c].add(sums_of(one, bounds)[c], 1);
  const auto added = records_of(sums, bounds), whole = records_of(history, bounds);
  for (std::size_t c = 0; c < whole.size(); ++c) {
    EXPECT_NEAR(added[c].exposure, whole[c].exposure, 1e-12);
    EXPECT_TRUE(added[c].splits == whole[c].splits);
  }
  FragmentHistory untold = history;
  untold[1].splits[0].agglomerate = 0;
  EXPECT_TRUE(by_agglomerate(untold, 4).empty());
}

TEST(BreakageRates, HaveTheExactIntervalOfACount) {
  const Rate none = rate_of(0, 2.0), ten = rate_of(10, 1.0);

  EXPECT_EQ(none.low, 0.0);
  EXPECT_NEAR(none.high, -std::log(0.025) / 2.0, 1e-12);  // P(0) = exp(-rate exposure) = 0.025
  EXPECT_NEAR(ten.low, 4.795389, 1e-6);                   // Garwood's table
  EXPECT_NEAR(ten.high, 18.390356, 1e-6);
}

TEST(SelectionLaw, FindsSizeAndSpeedsOfManyCases) {
  // ln rate = ln a + p ln(n / 37) + q ln(omega): three speeds, each with its own history.
  std::vector<CountedEvents> counts;
  unsigned seed = 1;
  for (const double omega : {1.0, 2.0, 4.0}) {
    const auto law = [omega](int size) { return 0.3 * std::pow(size / 37.0, 0.7) * std::pow(omega, 1.3); };
    const FragmentHistory history = simulated(law, 200, 37, 1.0, 0.01, seed++);
    for (const SizeRecord& record : records_of(history, size_bounds(37)))
      if (record.exposure > 0.0)
        counts.push_back({{1.0, std::log(record.mean_size / 37.0), std::log(omega)},
                          record.exposure,
                          static_cast<double>(record.all_splits())});
  }

  const auto law = fit_selection_law(counts);

  ASSERT_TRUE(law) << law.error().message;
  const double known[] = {std::log(0.3), 0.7, 1.3};
  for (std::size_t j = 0; j < 3; ++j)
    EXPECT_NEAR(law->coefficient[j], known[j], 2.6 * std::sqrt(law->covariance[j][j])) << j;
  EXPECT_LT(std::sqrt(law->covariance[2][2]), 0.15);
  EXPECT_LT(law->dispersion, 2.0);
  const Rate at = law->at({1.0, 0.0, std::log(3.0)});
  EXPECT_LT(at.low, 0.3 * std::pow(3.0, 1.3));
  EXPECT_GT(at.high, 0.3 * std::pow(3.0, 1.3));
}

TEST(SelectionLaw, SaysWhatItCannotKnow) {
  EXPECT_FALSE(fit_selection_law({{{1.0}, 1.0, 0.0}, {{1.0}, 2.0, 0.0}}));
  EXPECT_FALSE(fit_selection_law({{{1.0, 2.0}, 1.0, 3.0}, {{2.0, 4.0}, 2.0, 1.0}, {{3.0, 6.0}, 2.0, 1.0}}));
  EXPECT_FALSE(fit_selection_law({}));
}

TEST(SelectionLaw, StaysFiniteWithAPriorWhereASizeNeverBreaks) {
  const std::vector<CountedEvents> counts{{{1.0, 0.0}, 100.0, 50.0}, {{1.0, -1.0}, 100.0, 0.0}};

  const auto law = fit_selection_law(counts, 3.0);

  ASSERT_TRUE(law) << law.error().message;
  EXPECT_NEAR(law->at({1.0, 0.0}).value, 0.5, 0.02);
  EXPECT_LT(law->at({1.0, -1.0}).value, 0.02);
}

TEST(Daughters, KeepAllOfTheParentWhateverTheSplits) {
  const FragmentHistory history = simulated(power_law, 100, 37, 2.0, 0.1, 3);
  std::vector<Split> splits;
  for (const FragmentSample& sample : history) splits.insert(splits.end(), sample.splits.begin(), sample.splits.end());

  for (const auto& [from, to] : {std::pair{2, 2}, {5, 9}, {37, 37}, {2, 37}}) {
    double volume = 0.0, number = 0.0;
    for (const MeanDaughter& daughter : mean_daughters({{&splits, 0.5}}, from, to))
      volume += daughter.share * daughter.number, number += daughter.number;
    EXPECT_NEAR(volume, 1.0, 1e-12);
    EXPECT_GE(number, 2.0 - 1e-12);
  }
  EXPECT_TRUE(mean_daughters({{&splits}}, 40, 50).empty());
}

TEST(Daughters, AreCountedByTheirShares) {
  const std::vector<Split> chips{{37, {36, 1}, ""}, {37, {36, 1}, ""}}, other{{37, {35, 1, 1}, ""}, {8, {4, 4}, ""}};

  const auto daughters = mean_daughters({{&chips}, {&other}}, 37, 37);

  ASSERT_EQ(daughters.size(), 3u);  // rising: 1, 35 and 36 of 37; the parent of 8 is another's
  EXPECT_NEAR(daughters[0].share, 1.0 / 37.0, 1e-15);
  EXPECT_NEAR(daughters[0].number, 4.0 / 3.0, 1e-12);
  EXPECT_NEAR(daughters[1].number, 1.0 / 3.0, 1e-12);
  EXPECT_NEAR(daughters[2].number, 2.0 / 3.0, 1e-12);
  const auto weighted = mean_daughters({{&chips, 3.0}, {&other, 2.0}}, 37, 37);  // 6 chips to 2 others
  EXPECT_NEAR(weighted[0].number, (6.0 + 2.0 * 2.0) / 8.0, 1e-12);
}

TEST(FragmentHistory, IsReadFromItsLinesAndHeldAgainstItself) {
  const auto line = [](const char* text) { return json::parse(text, "line").value(); };
  const json::Value first = line(R"({"time_s": 0.0, "sizes": [[37, 2]], "splits": []})");
  const json::Value second = line(
      R"({"time_s": 0.1, "sizes": [[2, 1], [35, 1], [37, 1]],
          "splits": [{"parent": 37, "daughters": [35, 2], "cause": "chopper"}]})");
  const json::Value wrong =
      line(R"({"time_s": 0.1, "sizes": [], "splits": [{"parent": 37, "daughters": [35, 1], "cause": "chopper"}]})");

  const auto history = history_of({first, second}, "fragments.jsonl");
  ASSERT_TRUE(history) << history.error().message;
  EXPECT_EQ((*history)[1].alive.at(35), 1);
  EXPECT_EQ((*history)[1].splits.at(0).cause, "chopper");
  const auto refused = history_of({first, wrong}, "fragments.jsonl");
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, testing::HasSubstr("fragments.jsonl: line 2"));
  EXPECT_FALSE(history_of({second, first}, "fragments.jsonl"));
}

}  // namespace
}  // namespace granary::estimation
