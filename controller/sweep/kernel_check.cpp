#include "controller/sweep/kernel_check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "common/files.hpp"
#include "common/json/io.hpp"
#include "common/math/size_distribution.hpp"
#include "common/results/hdf5_file.hpp"
#include "pilot/launch/run_program.hpp"

namespace granary::sweep {
namespace {

namespace fs = std::filesystem;

constexpr int kTimes = 40;  // compared, at most

std::vector<double> pivots_of(const pbm::PbmCase& balance) {
  std::vector<double> pivots;
  for (int i = 0; i < balance.grid.bins[0]; ++i)
    pivots.push_back(balance.grid.smallest[0] * std::pow(balance.grid.ratio[0], i));
  return pivots;
}

/// Numbers of each class: a fragment between two pivots is shared so that number and volume stay.
std::vector<double> on_pivots(const estimation::FragmentSample& sample, double sphere_volume,
                              const std::vector<double>& pivots) {
  std::vector<double> number(pivots.size(), 0.0);
  for (const auto& [size, n] : sample.alive) {
    const double v = size * sphere_volume;
    const auto above = std::upper_bound(pivots.begin(), pivots.end(), v * (1.0 + 1e-9));
    const auto lower = static_cast<std::size_t>(std::max<std::ptrdiff_t>(0, above - pivots.begin() - 1));
    const bool inside = lower + 1 < pivots.size();
    const double up = inside ? std::clamp((v - pivots[lower]) / (pivots[lower + 1] - pivots[lower]), 0.0, 1.0) : 0.0;
    number[lower] += (1.0 - up) * static_cast<double>(n);
    if (inside) number[lower + 1] += up * static_cast<double>(n);
  }
  return number;
}

double d50_of(const std::vector<double>& number, const std::vector<double>& pivots) {
  std::vector<double> diameter, volume;
  for (std::size_t i = 0; i < pivots.size(); ++i) {
    diameter.push_back(sphere_diameter(pivots[i]));
    volume.push_back(std::max(0.0, number[i]) * pivots[i]);
  }
  const std::vector<double> no_second{0.0};
  return quantile(diameter, volume, 0.5, log_width_of_pivots(pivots, no_second));
}

double sum(const std::vector<double>& values) {
  double total = 0.0;
  for (const double value : values) total += value;
  return total;
}

/// Every so many samples, so that there are at most kTimes.
std::size_t stride_of(const ResolvedCase& one) { return (one.history.size() + kTimes - 1) / kTimes; }

const estimation::FragmentSample& sample_near(const ResolvedCase& one, double time) {
  return *std::min_element(one.history.begin(), one.history.end(), [&](const auto& a, const auto& b) {
    return std::abs(a.time - time) < std::abs(b.time - time);
  });
}

}  // namespace

double Comparison::mean_error() const {
  double total = 0.0;
  for (std::size_t t = 1; t < time.size(); ++t) total += std::abs(pbm_d50[t] / dem_d50[t] - 1.0);
  return time.size() > 1 ? total / static_cast<double>(time.size() - 1) : 0.0;
}

double Comparison::last_error() const { return time.empty() ? 0.0 : pbm_d50.back() / dem_d50.back() - 1.0; }

pbm::PbmCase balance_of(const BreakageKernel& kernel, const ResolvedCase& one, int bins) {
  pbm::PbmCase balance;
  balance.name = "kernel-" + one.name;
  balance.grid.bins = {bins, 1};
  balance.grid.smallest = {one.sphere_volume, 0.0};
  balance.grid.ratio = {std::pow(static_cast<double>(one.spheres), 1.0 / (bins - 1)), 2.0};
  balance.compartments.volume = {1.0};  // nothing depends on it: there is no aggregation
  balance.breakage.emplace();
  balance.breakage->selection = pbm::Breakage::Selection::table;
  balance.breakage->daughters = pbm::Breakage::Daughters::table;
  balance.breakage->table = kernel.table(one);
  const auto number = on_pivots(one.history.front(), one.sphere_volume, pivots_of(balance));
  for (int i = 0; i < bins; ++i)
    if (const double n = number[static_cast<std::size_t>(i)]; n > 0.0)
      balance.initial.push_back({-1, i, 0, n, 0.0, 0.0});
  balance.start_time = one.history.front().time;
  balance.end_time = one.history.back().time;
  const double every = (balance.end_time - balance.start_time) / static_cast<double>(one.history.size() - 1);
  balance.output_every = every * static_cast<double>(stride_of(one));
  balance.relative_tolerance = 1e-4;
  return balance;
}

Result<Comparison> compare(const BreakageKernel& kernel, const ResolvedCase& one, const fs::path& folder,
                           const fs::path& programs) {
  const pbm::PbmCase balance = balance_of(kernel, one);
  const auto pivots = pivots_of(balance);
  GRANARY_CHECK(make_folders(folder));
  const fs::path file = folder / "case.json", out = folder / "out.h5";
  GRANARY_CHECK(json::write_file(file, pbm::to_json(balance)));
  GRANARY_TRY(const auto ran,
              pilot::run_program({(programs / "granary-pbm").string(), "run", file.string(), "--out", out.string()}, "",
                                 600.0));
  if (ran.exit_code != 0)
    return Error{fmt::format("{}: granary-pbm ended with {}: {}", file.string(), ran.exit_code, ran.err),
                 Exit::task_failed};
  GRANARY_TRY(const Hdf5File h5, Hdf5File::open(out));
  GRANARY_TRY(const DataArray times, h5.read("/state/time"));
  Comparison comparison;
  comparison.name = one.name;
  for (std::size_t row = 0; row < times.values.size(); ++row) {
    GRANARY_TRY(const std::vector<double> number, h5.read_row("/state/number", row));
    const auto& sample = sample_near(one, times.values[row]);
    const auto seen = on_pivots(sample, one.sphere_volume, pivots);
    comparison.time.push_back(times.values[row]);
    comparison.dem_d50.push_back(d50_of(seen, pivots));
    comparison.pbm_d50.push_back(d50_of(number, pivots));
    comparison.dem_number.push_back(sum(seen));
    comparison.pbm_number.push_back(sum(number));
  }
  return comparison;
}

}  // namespace granary::sweep
