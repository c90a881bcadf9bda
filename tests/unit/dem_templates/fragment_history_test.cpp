// Fragments from the graph of the bonds, their sizes, and what is told of them.
#include "dem_templates/plugin/bond/fragment_history.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "common/json/io.hpp"

namespace granary::dem {
namespace {

/// n particles of 1 mm in a row, each bonded to the next, of one agglomerate.
FragmentSurvey row(Tag n) {
  FragmentSurvey survey;
  for (Tag k = 1; k <= n; ++k) {
    survey.particles.push_back({k, 1, {{1e-3 * static_cast<double>(k), 0, 0}, 0.5e-3}});
    if (k > 1) survey.bonds.emplace_back(k - 1, k);
  }
  return survey;
}

FragmentSurvey without(FragmentSurvey survey, Tag a, Tag b) {
  std::erase(survey.bonds, std::pair<Tag, Tag>(a, b));
  return survey;
}

BreakEvent broken(double step, Tag a, Tag b) {
  return {.step = step, .time = 1e-6 * step, .agglomerate = 1, .tag = a, .far_tag = b, .stress = 1e5};
}

FragmentHistory started(Tag n) {
  FragmentHistory history;
  history.set_causes({"particles", "chopper", "shell"}, 100.0);
  history.start(row(n));
  history.sample_line(0.0, 0.0, row(n));
  return history;
}

TEST(BondGraph, FallsIntoItsFragments) {
  BondGraph graph;
  for (Tag k = 1; k <= 5; ++k) graph.add_particle(k);
  graph.add_bond(1, 3);
  graph.add_bond(3, 5);
  graph.add_bond(1, 5);
  graph.add_bond(2, 4);
  using Fragments = std::vector<std::vector<Tag>>;
  EXPECT_EQ(graph.fragments(), (Fragments{{1, 3, 5}, {2, 4}}));
  graph.remove_bond(3, 5);
  EXPECT_EQ(graph.fragments().size(), 2u);  // it still hangs together by 1
  graph.remove_bond(1, 3);
  EXPECT_EQ(graph.fragments(), (Fragments{{1, 5}, {2, 4}, {3}}));
  EXPECT_EQ(graph.fragment_of(5), (std::vector<Tag>{1, 5}));
}

TEST(BondGraph, LabelsEachParticleWithTheLowestTagOfItsFragment) {
  EXPECT_EQ(fragment_labels({{6, 7}, {3, 5}, {5, 6}, {2, 4}}), (std::vector<Tag>{0, 1, 2, 3, 2, 3, 3, 3}));
  EXPECT_EQ(fragment_labels({}), (std::vector<Tag>{0}));
}

TEST(Splits, NameTheDaughtersLargestFirstAndNoFragmentThatStayedWhole) {
  const auto splits = splits_between({{1, 2, 3, 4}, {5, 6}, {7}}, {{1}, {2, 3, 4}, {5, 6}, {7}});
  ASSERT_EQ(splits.size(), 1u);
  EXPECT_EQ(splits[0].parent.size(), 4u);
  EXPECT_EQ(splits[0].daughters, (std::vector<std::size_t>{3, 1}));
  EXPECT_TRUE(splits_between({{1, 2, 3}}, {{1, 2}}).empty());  // one has left, nothing has broken
}

TEST(FragmentSize, OfOneSphereIsItsDiameterBothWays) {
  const FragmentSurvey survey = row(1);
  BondGraph graph;
  graph.add_particle(1);
  const FragmentSize size = fragment_size({1}, graph, {{1, survey.particles[0].shape}}, {});
  EXPECT_NEAR(size.diameter, 1e-3, 1e-15);
  EXPECT_NEAR(size.spread_diameter, 1e-3, 1e-15);
}

TEST(FragmentSize, OfADenseBallIsTheBallsDiameterByGyration) {
  BondGraph graph;
  std::unordered_map<Tag, FragmentParticle> particles;
  std::vector<Tag> all;
  Tag tag = 0;
  for (int i = -12; i <= 12; ++i)
    for (int j = -12; j <= 12; ++j)
      for (int k = -12; k <= 12; ++k) {
        if (i * i + j * j + k * k > 144) continue;
        particles[++tag] = {{1e-3 * i, 1e-3 * j, 1e-3 * k}, 0.5e-3};
        all.push_back(tag);
        graph.add_particle(tag);
        if (tag > 1) graph.add_bond(tag - 1, tag);
      }
  const FragmentSize size = fragment_size(all, graph, particles, {});
  EXPECT_NEAR(size.spread_diameter / 24e-3, 1.0, 0.02);
  EXPECT_NEAR(size.diameter, 1e-3 * std::cbrt(static_cast<double>(tag)), 1e-12);
}

TEST(FragmentSize, FollowsBondsAcrossAPeriodicBoundary) {
  BondGraph graph;
  graph.add_bond(1, 2);
  const std::unordered_map<Tag, FragmentParticle> whole{{1, {{0.0095, 0, 0}, 5e-4}}, {2, {{0.0105, 0, 0}, 5e-4}}};
  const std::unordered_map<Tag, FragmentParticle> folded{{1, {{0.0095, 0, 0}, 5e-4}}, {2, {{0.0005, 0, 0}, 5e-4}}};
  EXPECT_NEAR(fragment_size({1, 2}, graph, folded, {0.01, 0, 0}).spread_diameter,
              fragment_size({1, 2}, graph, whole, {}).spread_diameter, 1e-15);
}

TEST(WeightedQuantile, IsTheSizeAtWhichTheWeightIsReached) {
  EXPECT_EQ(weighted_quantile({{3, 1}, {1, 1}, {2, 2}}, 0.5), 2.0);
  EXPECT_EQ(weighted_quantile({{3, 1}, {1, 1}, {2, 2}}, 0.25), 1.0);
  EXPECT_EQ(weighted_quantile({{3, 1}, {1, 1}, {2, 2}}, 0.84), 3.0);
  EXPECT_EQ(weighted_quantile({}, 0.5), 0.0);
}

TEST(FragmentHistory, TellsOfEachBreakTheFragmentBeforeItAndWhatLeantOnIt) {
  FragmentHistory history = started(6);
  // The second break comes first; the chopper leans on 5, the shell, deeper, on 1.
  const auto lines = history.break_lines({broken(50, 4, 5), broken(40, 2, 3)},
                                         {{1, {2.0, 0.02, 45.0}}, {5, {1.0, 0.01, 30.0}}, {6, {0.0, 0.5, -500.0}}});
  ASSERT_EQ(lines.size(), 2u);
  EXPECT_EQ(lines[0]["tags"], json::Value(json::Array{2, 3}));
  EXPECT_EQ(lines[0]["fragment_spheres"].as_integer(), 6);
  EXPECT_EQ(lines[0]["cause"].as_string(), "shell");  // deeper
  EXPECT_EQ(lines[1]["fragment_spheres"].as_integer(), 4);
  EXPECT_EQ(lines[1]["cause"].as_string(), "chopper");  // the shell leans on another piece, 6 was touched too long ago
}

TEST(FragmentHistory, SampleCountsBondsSizesAndSplits) {
  FragmentHistory history = started(6);
  history.break_lines({broken(50, 4, 5)}, {{5, {1.0, 0.01, 30.0}}});
  const json::Value line = history.sample_line(1e-4, 100.0, without(row(6), 4, 5));
  std::vector<std::string> keys;
  for (const auto& [key, value] : line.members()) keys.push_back(key);
  EXPECT_EQ(keys, (std::vector<std::string>{"time_s", "step", "bonds", "broken", "breakage_ratio",
                                            "agglomerate_breakage_ratio", "fragments", "d50_m", "d84_m", "sigma",
                                            "d50_hull_m", "d84_hull_m", "sizes", "splits"}));
  EXPECT_EQ(line["bonds"].as_integer(), 4);
  EXPECT_EQ(line["broken"].as_integer(), 1);
  EXPECT_DOUBLE_EQ(line["breakage_ratio"].as_number(), 0.2);
  EXPECT_EQ(line["fragments"].as_integer(), 2);
  EXPECT_NEAR(line["d50_m"].as_number(), 1e-3 * std::cbrt(4.0), 1e-12);
  EXPECT_EQ(json::dump(line["sizes"]), "[[2,1],[4,1]]");
  EXPECT_EQ(json::dump(line["splits"]), R"([{"parent":6,"daughters":[4,2],"cause":"chopper","agglomerate":1}])");
  // Nothing more broke: nothing more split.
  EXPECT_EQ(history.sample_line(2e-4, 200.0, without(row(6), 4, 5))["splits"].size(), 0u);
}

TEST(FragmentHistory, WhatABlowSetsOffIsItsDoingWhenTheStruckParticlesHaveComeOff) {
  // The window is 100 steps. The chopper strikes 6; later, debris of the same agglomerate leans on 1.
  FragmentHistory history = started(6);
  const std::unordered_map<Tag, Squeeze> touched{{6, {1.0, 0.01, 50.0}}, {1, {0.0, 1e-10, 160.0}}};
  const auto lines =
      history.break_lines({broken(50, 5, 6), broken(60, 2, 3), broken(195, 1, 2), broken(195, 3, 4)}, touched);
  EXPECT_EQ(lines[0]["cause"].as_string(), "chopper");
  EXPECT_EQ(lines[1]["cause"].as_string(), "chopper");    // no longer one piece with 6, but it was
  EXPECT_EQ(lines[2]["cause"].as_string(), "particles");  // too long after: the debris is left
  EXPECT_EQ(lines[3]["cause"].as_string(), "none");
}

TEST(FragmentHistory, GoesOnFromItsState) {
  FragmentHistory history = started(6);
  history.break_lines({broken(50, 4, 5)}, {{5, {1.0, 0.01, 30.0}}});
  FragmentHistory other;
  other.set_causes({"particles", "chopper", "shell"}, 40.0);
  other.set_state(history.state().data());
  other.start(without(row(6), 4, 5));
  EXPECT_EQ(other.last_sample(), 0.0);
  const json::Value line = other.sample_line(1e-4, 100.0, without(row(6), 4, 5));
  EXPECT_EQ(line["broken"].as_integer(), 1);
  EXPECT_EQ(line["agglomerate_breakage_ratio"].as_number(), 1.0);
  ASSERT_EQ(line["splits"].size(), 1u);
  EXPECT_EQ(line["splits"].items()[0]["cause"].as_string(), "chopper");
}

}  // namespace
}  // namespace granary::dem
