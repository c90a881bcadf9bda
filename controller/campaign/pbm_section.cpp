// pbm: the grid, the mechanisms that are modelled, and how the balance is integrated. A mechanism left out is not
// modelled.
#include <fmt/format.h>

#include <algorithm>

#include "common/json/io.hpp"
#include "common/json/reader.hpp"
#include "controller/campaign/sections.hpp"

namespace granary::campaign {
namespace {

using json::Range;

void read_grid(json::Reader& pbm, pbm::Grid& grid, json::Problems& problems) {
  grid.bins = integer_pair_or(pbm, "bins", grid.bins, Range::between(2, 256), problems);
  grid.ratio = number_pair_or(pbm, "ratio", grid.ratio, {1.0, 100.0, false, true}, problems);
  grid.smallest = quantity_pair_or(pbm, "smallest_solid", grid.smallest, "m^3", Range::positive(), problems);
}

void read_efficiency(json::Reader reader, pbm::Efficiency& efficiency) {
  using Model = pbm::Efficiency::Model;
  const std::string model = reader.choice_or("model", "stokes", {"constant", "wet", "stokes"});
  efficiency.model = model == "constant" ? Model::constant : model == "wet" ? Model::wet : Model::stokes;
  efficiency.value = reader.number_or("value", efficiency.value, Range::fraction());
  efficiency.least_liquid_fraction =
      reader.number_or("least_liquid_fraction", efficiency.least_liquid_fraction, Range::fraction());
  efficiency.restitution = reader.number_or("restitution", efficiency.restitution, {0.0, 1.0, false, true});
  efficiency.asperity = reader.quantity_or("asperity", efficiency.asperity, "m", Range::positive());
  reader.done();
}

/// The rate has the unit of what it multiplies: none beside the DEM's own rates.
double read_rate(json::Reader& reader, bool from_dem, const std::string& si_unit) {
  return from_dem ? reader.number_or("rate", 1.0, Range::not_negative())
                  : reader.quantity("rate", si_unit, Range::not_negative());
}

/// One row of rates for each diameter; the rows must make a symmetric table over rising diameters.
pbm::KernelTable read_table(json::Reader& reader) {
  pbm::KernelTable table;
  for (json::Reader& row : reader.items("table")) {
    table.diameter.push_back(row.quantity("diameter", "m", Range::positive()));
    table.rate.push_back(row.quantities("rates", "m^3/s", Range::not_negative()));
    row.done();
  }
  const std::size_t n = table.diameter.size();
  for (std::size_t p = 0; p < n; ++p) {
    if (table.rate[p].size() != n) {
      reader.problem("table", fmt::format("row {} has {} rates; it must have {}, one for each diameter.", p + 1,
                                          table.rate[p].size(), n));
      return {};
    }
    if (p > 0 && !(table.diameter[p] > table.diameter[p - 1])) {
      reader.problem("table", fmt::format("the diameters must rise, but that of row {} does not.", p + 1));
      return {};
    }
    for (std::size_t q = 0; q < p; ++q)
      if (table.rate[p][q] != table.rate[q][p]) {
        reader.problem(
            "table",
            fmt::format("it must be symmetric, but rate {1} of row {0} and rate {0} of row {1} differ.", p + 1, q + 1));
        return {};
      }
  }
  return table;
}

pbm::Aggregation read_aggregation(json::Reader reader, json::Problems& problems) {
  using Kernel = pbm::Aggregation::Kernel;
  pbm::Aggregation aggregation;
  const std::vector<std::string> kernels{"constant", "sum", "product",
                                         "shear",    "dem", "table"};  // as in pbm::Aggregation
  const std::string kernel = reader.choice_or("kernel", "dem", kernels);
  aggregation.kernel = static_cast<Kernel>(std::find(kernels.begin(), kernels.end(), kernel) - kernels.begin());
  aggregation.rate = read_rate(reader, kernel == "dem" || kernel == "table", kernel == "shear" ? "1/s" : "m^3/s");
  aggregation.lookup = reader.choice_or("lookup", "size", {"size", "group"}) == "size"
                           ? pbm::Aggregation::Lookup::size
                           : pbm::Aggregation::Lookup::group;
  aggregation.table = read_table(reader);
  if (kernel == "table" && aggregation.table.diameter.empty())
    reader.problem("table", "the kernel \"table\" needs it.", "Give a row with diameter and rates for each size.");
  read_efficiency(section_or_empty(reader, "efficiency", problems), aggregation.efficiency);
  reader.done();
  return aggregation;
}

/// The kernel that `granary kernel` made of a resolved breakage.
pbm::BreakageTable read_kernel_file(json::Reader& reader, const Campaign& campaign) {
  const std::filesystem::path file = campaign.folder / reader.text("table");
  const auto document = json::read_file(file);
  const auto table =
      document ? pbm::read_breakage_table(*document, file.string()) : Result<pbm::BreakageTable>(document.error());
  if (table) return *table;
  reader.problem("table", "it cannot be used: " + table.error().message, "granary kernel writes such a file.");
  return {};
}

pbm::Breakage read_breakage(json::Reader reader, const Campaign& campaign) {
  using Selection = pbm::Breakage::Selection;
  using Daughters = pbm::Breakage::Daughters;
  pbm::Breakage breakage;
  const std::string selection =
      reader.choice_or("selection", "impact", {"impact", "constant", "linear", "power", "table"});
  breakage.selection = selection == "impact"     ? Selection::impact
                       : selection == "constant" ? Selection::constant
                       : selection == "linear"   ? Selection::linear
                       : selection == "power"    ? Selection::power
                                                 : Selection::table;
  breakage.exponent = reader.number_or("exponent", breakage.exponent, Range::between(0.0, 10.0));
  const std::string daughters =
      reader.choice_or("daughters", "uniform_binary", {"uniform_binary", "halves", "same_composition", "table"});
  breakage.daughters = daughters == "uniform_binary" ? Daughters::uniform_binary
                       : daughters == "halves"       ? Daughters::halves
                       : daughters == "table"        ? Daughters::table
                                                     : Daughters::same_composition;
  if (selection == "table" || daughters == "table")
    breakage.table = read_kernel_file(reader, campaign);
  else if (reader.has("table"))
    reader.problem("table", "neither selection nor daughters are of it.",
                   "Remove it, or set one of them to \"table\".");
  breakage.rate = read_rate(reader, selection == "impact" || selection == "table", "1/s");
  breakage.critical_stokes_deformation =
      reader.number_or("critical_stokes_deformation", breakage.critical_stokes_deformation, Range::positive());
  breakage.primary_diameter = reader.quantity_or("primary_diameter", breakage.primary_diameter, "m", Range::positive());
  reader.done();
  return breakage;
}

pbm::Consolidation read_consolidation(json::Reader reader) {
  pbm::Consolidation consolidation;
  consolidation.rate = reader.quantity("rate", "1/s", Range::not_negative());
  consolidation.least_porosity =
      reader.number_or("least_porosity", consolidation.least_porosity, {0.0, 1.0, true, false});
  reader.done();
  return consolidation;
}

}  // namespace

void read_pbm(json::Reader& root, Campaign& campaign, json::Problems& problems) {
  json::Reader reader = section_or_empty(root, "pbm", problems);
  pbm::PbmCase& base = campaign.pbm_case;
  read_grid(reader, base.grid, problems);
  base.relative_tolerance = reader.number_or("tolerance", base.relative_tolerance, {0.0, 0.1, false, true});
  base.kernel_tolerance = reader.number_or("kernel_tolerance", base.kernel_tolerance, Range::between(0.0, 0.1));
  base.output_every = reader.quantity_or("output_every", base.output_every, "s", Range::positive());
  base.reference_volume = reader.quantity_or("reference_volume", base.reference_volume, "m^3", Range::positive());
  if (auto section = reader.optional_section("aggregation")) base.aggregation = read_aggregation(*section, problems);
  if (auto section = reader.optional_section("breakage")) base.breakage = read_breakage(*section, campaign);
  if (auto section = reader.optional_section("consolidation")) base.consolidation = read_consolidation(*section);

  PbmSettings& pbm = campaign.pbm;
  pbm.longest_burst = reader.quantity_or("longest_burst", pbm.longest_burst, "s", Range::positive());
  pbm.ranks = static_cast<int>(reader.integer_or("ranks", pbm.ranks, Range::between(1, 100000)));
  pbm.threads = static_cast<int>(reader.integer_or("threads", pbm.threads, Range::between(1, 1024)));
  reader.done();
}

}  // namespace granary::campaign
