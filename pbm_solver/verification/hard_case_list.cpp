// Which hard cases there are.
#include <algorithm>
#include <cmath>
#include <numeric>

#include "pbm_solver/model/model_tables.hpp"
#include "pbm_solver/verification/hard_cases.hpp"

namespace granary::pbm {
namespace {

constexpr double kTolerance = 1e-4;

double sum(const std::vector<double>& list) { return std::accumulate(list.begin(), list.end(), 0.0); }

double oversize(const Snapshot& s, std::size_t entry) {
  double all = 0.0;
  for (std::size_t at = 0; at < s.ledger.size(); at += ledger::kSize) all += s.ledger[at + entry];
  return all;
}

/// n x n classes of this ratio, one closed compartment of 1 m^3, four outputs.
PbmCase batch(int bins, double ratio, double end, bool two_solids = true) {
  PbmCase c;
  c.grid = {{bins, two_solids ? bins : 1}, {1.0, two_solids ? 1.0 : 0.0}, {ratio, ratio}};
  c.compartments.volume = {1.0};
  c.relative_tolerance = kTolerance;
  c.end_time = end, c.output_every = 0.25 * end;
  return c;
}

Aggregation aggregation(double rate, Aggregation::Kernel kernel = Aggregation::Kernel::constant) {
  Aggregation a;
  a.kernel = kernel, a.rate = rate;
  return a;
}

Breakage breakage(double rate, double exponent) {
  Breakage b;
  b.selection = Breakage::Selection::power;
  b.rate = rate, b.exponent = exponent;
  return b;
}

void exponential_start(PbmCase& c, double mean) {
  const ClassGrid grid(c.grid);
  for (int i = 0; i < c.grid.bins[0]; ++i)
    for (int j = 0; j < c.grid.bins[1]; ++j) {
      const double v = grid.solid()[grid.index(i, j)];
      const double number = v * v / (mean * mean) * std::exp(-v / mean);
      if (number > 0.0) c.initial.push_back({0, i, j, number, 0.1 * v * number, 0.2 * v * number});
    }
}

/// Particles, with those above the grid, against Smoluchowski's constant kernel: N0 / (1 + beta N0 t / 2). Every
/// collision above the grid leaves one particle that collides no more: exact while there are few of these.
NamedErrors constant_kernel_number(const PbmCase& c, const Snapshot& s) {
  double start = 0.0;
  for (const InitialClass& one : c.initial) start += one.number;
  const double exact = start / (1.0 + 0.5 * c.aggregation->rate * start * c.end_time);
  return {{"M00", (sum(s.number) + oversize(s, ledger::kOversizeNumber)) / exact - 1.0}};
}

NamedErrors number_of_constant_kernel(const PbmCase& c, const ClassGrid&, const Snapshot& s) {
  return constant_kernel_number(c, s);
}

/// A row of stirred tanks of one fed class: k = count / residence time.
PbmCase row_of_tanks(int count, double residence_time, double end) {
  PbmCase c = batch(4, 2.0, end);
  c.compartments = {count, std::vector<double>(static_cast<std::size_t>(count), 1.0), residence_time};
  c.feed = Feed{};
  c.feed->classes = {{0, 1, 1e6}};
  c.feed->porosity = 0.4;
  return c;
}

/// Feed, spray, flow, collisions by diameter and everything else that happens in a mixer.
PbmCase mixer(double rate, double end) {
  PbmCase c = batch(10, 3.0, end);
  c.grid.smallest = {5e-16, 5e-16};
  c.compartments = {3, {1e-3, 1e-3, 1e-3}, 6.0};
  c.feed = Feed{};
  for (int k = 0; k < 6; ++k) c.feed->classes.push_back({k, k, 7e8 * std::pow(2.5, -k)});
  c.feed->porosity = 0.5;
  c.spray = Spray{1.5e-6, 0, 0.0, 1e300};
  c.aggregation = aggregation(rate, Aggregation::Kernel::shear);
  c.breakage = breakage(1e-2, 0.5);
  c.reference_volume = 1e-13;
  c.consolidation = Consolidation{0.02, 0.2};
  return c;
}

HardCase stiff(const char* name, double exponent, double fastest) {
  return {name,
          "aggregation against breakage that is far faster than the horizon",
          "ten times the tolerance, at rest",
          10.0 * kTolerance,
          1e-7,
          {},
          false,
          [=] {
            PbmCase c = batch(16, 2.0, 0.4);
            c.grid.smallest = {1.0 / 512.0, 1.0 / 512.0};
            c.aggregation = aggregation(10.0);
            const ClassGrid grid(c.grid);
            c.breakage = breakage(fastest / c.end_time / std::pow(grid.solid().back(), exponent), exponent);
            exponential_start(c, 1.0);
            return c;
          }};
}

HardCase product(const char* name, const char* text, const char* reason, double end, NamedErrors bounds) {
  return {name,
          text,
          reason,
          0.0,
          0.0,
          std::move(bounds),
          false,
          [=] {
            PbmCase c = batch(16, 2.0, end, false);
            c.aggregation = aggregation(1.0, Aggregation::Kernel::product);
            c.initial = {{0, 0, 0, 1.0, 0.0, 0.0}};
            return c;
          },
          [=](const PbmCase&, const ClassGrid& grid, const Snapshot& s) -> NamedErrors {
            double mass = 0.0;
            for (std::size_t k = 0; k < grid.size(); ++k) mass += grid.solid()[k] * s.number[k];
            const double lost = oversize(s, ledger::kOversize);
            NamedErrors errors{{"reported_loss", mass + lost - 1.0}};
            if (end < 1.0) errors.emplace_back("M00", sum(s.number) / (1.0 - 0.5 * end) - 1.0);
            if (end > 1.0) errors.emplace_back("sol_mass", mass * end - 1.0);
            return errors;
          }};
}

}  // namespace

std::vector<HardCase> hard_cases() {
  const auto pure = [] {
    PbmCase c = batch(18, 2.0, 1.0);
    c.initial = {{0, 8, 0, 500.0, 0.0, 0.0}, {0, 0, 8, 500.0, 40.0, 0.0}};
    c.aggregation = aggregation(0.02);
    return c;
  };
  std::vector<HardCase> all;
  all.push_back(stiff("stiff-breakage", 1.0, 1e4));
  all.push_back(stiff("stiff-breakage-1e7", 2.0, 1e7));
  all.push_back(product("gelation-before", "product kernel at 0.9 of the gel point",
                        "M00 = 1 - t/2 is the time steps' error, and 1 % for what the grid already loses", 0.9,
                        {{"M00", 1e-2}, {"reported_loss", 1e-12}}));
  all.push_back(product("gelation-past", "product kernel at twice the gel point: gel leaves the grid, and is reported",
                        "mass of the sol is 1/t on an endless grid; 10 % for a grid that ends at 3e4", 2.0,
                        {{"sol_mass", 0.1}, {"reported_loss", 1e-12}}));
  all.push_back({"grid-overflow",
                 "everything grows beyond a grid of five classes",
                 "ten times the tolerance",
                 10.0 * kTolerance,
                 1e-7,
                 {{"left_behind", 0.5}},
                 false,
                 [] {
                   PbmCase c = batch(5, 3.0, 3.0);
                   c.aggregation = aggregation(1.0, Aggregation::Kernel::product);
                   c.initial = {{0, 0, 0, 100.0, 10.0, 20.0}};
                   return c;
                 },
                 [](const PbmCase&, const ClassGrid&, const Snapshot& s) -> NamedErrors {
                   return {{"left_behind", 1.0 - (oversize(s, ledger::kOversize) / 100.0)}};
                 }});
  all.push_back({"growth-through-the-top",
                 "granules fill the largest classes, where every collision leaves the grid",
                 "twenty times the tolerance: all that is fed passes through classes that last microseconds",
                 20.0 * kTolerance,
                 1e-5,
                 {},
                 false,
                 [] { return mixer(3e4, 4.0); }});
  all.push_back({"empty-start",
                 "an empty mixer, fed and sprayed from the first moment",
                 "ten times the tolerance",
                 10.0 * kTolerance,
                 1e-6,
                 {},
                 false,
                 [] { return mixer(30.0, 2.0); }});
  all.push_back({"single-class",
                 "all particles in one class",
                 "M00 is the time steps' error",
                 0.0,
                 0.0,
                 {{"M00", 10.0 * kTolerance}},
                 false,
                 [] {
                   PbmCase c = batch(12, 2.0, 1.0);
                   c.initial = {{0, 0, 0, 1e3, 0.0, 0.0}};
                   c.aggregation = aggregation(0.02);
                   return c;
                 },
                 number_of_constant_kernel});
  all.push_back({"feed-switched",
                 "feed begins and ends between outputs",
                 "exact filling and emptying of the first tank",
                 0.0,
                 0.0,
                 {{"first_tank", 10.0 * kTolerance}},
                 false,
                 [] {
                   PbmCase c = row_of_tanks(3, 6.0, 6.0);
                   c.feed->start = 0.13, c.feed->end = 3.21;
                   return c;
                 },
                 [](const PbmCase& c, const ClassGrid& grid, const Snapshot& s) -> NamedErrors {
                   const double k = 0.5, fed = c.feed->end - c.feed->start, since = c.end_time - c.feed->end;
                   const double exact = 1e6 / k * -std::expm1(-k * fed) * std::exp(-k * since);
                   return {{"first_tank", s.number[grid.index(0, 1)] / exact - 1.0}};
                 }});
  all.push_back({"twelve-decades",
                 "one large granule among 1e12 fines",
                 "M00 is the time steps' error",
                 0.0,
                 0.0,
                 {{"M00", 10.0 * kTolerance}},
                 false,
                 [] {
                   PbmCase c = batch(16, 3.0, 4.0);
                   c.initial = {{0, 0, 0, 1e12, 0.0, 0.0}, {0, 12, 12, 1.0, 0.0, 0.0}};
                   c.aggregation = aggregation(1e-12);
                   return c;
                 },
                 number_of_constant_kernel});
  all.push_back({"zero-liquid",
                 "a wetness criterion and no liquid: nothing may happen",
                 "nothing happens, exactly",
                 0.0,
                 0.0,
                 {{"M00", 1e-15}},
                 false,
                 [] {
                   PbmCase c = batch(8, 2.0, 10.0);
                   c.initial = {{0, 2, 3, 1e9, 0.0, 1e8}};
                   c.aggregation = aggregation(1.0);
                   c.aggregation->efficiency.model = Efficiency::Model::wet;
                   return c;
                 },
                 [](const PbmCase&, const ClassGrid&, const Snapshot& s) -> NamedErrors {
                   return {{"M00", sum(s.number) / 1e9 - 1.0}};
                 }});
  all.push_back({"running-dry",
                 "nothing is fed; all but 1e-26 leaves the first tank",
                 "exponential decay, in units of the start",
                 0.0,
                 0.0,
                 {{"first_tank", 10.0 * kTolerance}},
                 false,
                 [] {
                   PbmCase c = row_of_tanks(2, 1.0, 30.0);
                   c.feed.reset();
                   c.initial = {{-1, 0, 1, 1e6, 1e5, 1e5}};
                   return c;
                 },
                 [](const PbmCase&, const ClassGrid& grid, const Snapshot& s) -> NamedErrors {
                   return {{"first_tank", s.number[grid.index(0, 1)] / 1e6 - std::exp(-60.0)}};
                 }});
  all.push_back({"rates-jump",
                 "a restart with collisions a thousand times faster, as at a switch from the DEM",
                 "ten times the tolerance",
                 10.0 * kTolerance,
                 1e-6,
                 {},
                 false,
                 [] { return mixer(3.0, 2.0); },
                 {},
                 [](PbmCase& c) { c.aggregation->rate *= 1e3; }});
  all.push_back({"long-horizon",
                 "1e5 s of aggregation, to 1/5000 of the number",
                 "M00 is the time steps' error",
                 0.0,
                 0.0,
                 {{"M00", 10.0 * kTolerance}},
                 false,
                 [] {
                   PbmCase c = batch(40, 2.0, 1e5, false);
                   c.initial = {{0, 0, 0, 1.0, 0.0, 0.0}};
                   c.aggregation = aggregation(0.1);
                   return c;
                 },
                 number_of_constant_kernel});
  all.push_back({"long-steady",
                 "1e5 s of aggregation against breakage, to rest",
                 "ten times the tolerance",
                 10.0 * kTolerance,
                 1e-6,
                 {},
                 false,
                 [] {
                   PbmCase c = batch(24, 2.0, 1e5, false);
                   c.initial = {{0, 6, 0, 1.0, 0.0, 0.0}};
                   c.aggregation = aggregation(0.1);
                   c.breakage = breakage(1e-3, 1.0);
                   return c;
                 }});
  all.push_back({"two-pure",
                 "granules of one solid each, in two classes",
                 "M00 is the time steps' error",
                 0.0,
                 0.0,
                 {{"M00", 10.0 * kTolerance}},
                 false,
                 pure,
                 number_of_constant_kernel});
  all.push_back({"one-size-feed",
                 "a stirred tank, one size fed into it",
                 "M00 follows a Riccati equation",
                 0.0,
                 0.0,
                 {{"M00", 10.0 * kTolerance}},
                 false,
                 [] {
                   PbmCase c = batch(30, 2.0, 8.0, false);
                   c.compartments.residence_time = 2.0;
                   c.feed = Feed{};
                   c.feed->classes = {{0, 0, 1e6}};
                   c.aggregation = aggregation(4e-6);
                   return c;
                 },
                 [](const PbmCase& c, const ClassGrid&, const Snapshot& s) -> NamedErrors {
                   // dM/dt = F - k M - beta M^2 / 2 from 0.
                   const double k = 0.5, half = 0.5 * c.aggregation->rate, root = std::sqrt(k * k + 4.0 * half * 1e6);
                   const double growth = std::exp(-root * c.end_time);
                   const double exact = 2.0 * 1e6 * (1.0 - growth) / ((root + k) + (root - k) * growth);
                   return {{"M00", (sum(s.number) + oversize(s, ledger::kOversizeNumber)) / exact - 1.0}};
                 }});
  for (const double exponent : {-10.0, 10.0})
    all.push_back({exponent < 0.0 ? "rates-1e-10" : "rates-1e+10",
                   "the same collisions twenty decades apart",
                   "M00 is the time steps' error",
                   0.0,
                   0.0,
                   {{"M00", 10.0 * kTolerance}},
                   false,
                   [=] {
                     PbmCase c = batch(12, 2.0, 0.1 * std::pow(10.0, -exponent));
                     c.initial = {{0, 0, 0, 100.0, 0.0, 10.0}};
                     c.aggregation = aggregation(std::pow(10.0, exponent));
                     return c;
                   },
                   number_of_constant_kernel});
  all.push_back({"64-tanks",
                 "flow through 64 tanks, each emptied 64 times a second",
                 "at rest each holds feed / k",
                 0.0,
                 0.0,
                 {{"last_tank", 10.0 * kTolerance}},
                 false,
                 [] { return row_of_tanks(64, 1.0, 4.0); },
                 [](const PbmCase&, const ClassGrid& grid, const Snapshot& s) -> NamedErrors {
                   return {{"last_tank", s.number[63 * grid.size() + grid.index(0, 1)] * 64.0 / 1e6 - 1.0}};
                 }});
  all.push_back({"impossible",
                 "collisions 1e40 times faster than the horizon",
                 "refused: exit 20, naming the settings",
                 0.0,
                 0.0,
                 {},
                 true,
                 [] {
                   PbmCase c = batch(8, 3.0, 1.0);
                   c.aggregation = aggregation(1e30);
                   c.initial = {{0, 0, 0, 1e10, 0.0, 0.0}};
                   return c;
                 }});
  return all;
}

}  // namespace granary::pbm
