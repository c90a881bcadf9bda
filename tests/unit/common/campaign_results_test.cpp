#include "common/results/campaign_results.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <filesystem>
#include <fstream>
#include <limits>
#include <map>
#include <set>
#include <sstream>

#include "common/files.hpp"
#include "common/results/hdf5_file.hpp"
#include "common/results/schema.hpp"
#include "tests/support/results_example.hpp"

namespace granary {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class CampaignResultsFile : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("granary-results-" + std::to_string(::getpid()));
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }
  fs::path file() const { return folder_ / "results.h5"; }

  fs::path folder_;
};

/// Paths of all datasets below a group; a group is what has children.
void collect_datasets(const Hdf5File& h5, const std::string& group, std::vector<std::string>& datasets) {
  auto children = h5.children(group);
  if (!children) return datasets.push_back(group);
  for (const auto& child : *children) collect_datasets(h5, (group == "/" ? "" : group) + "/" + child, datasets);
}

/// /rates/0003/diameter -> /rates/NNNN/diameter
std::string general_name(std::string name) {
  if (name.starts_with("/rates/")) name.replace(7, name.find('/', 7) - 7, "NNNN");
  return name;
}

// Equal bits, so that NaN equals NaN and -0.0 does not equal 0.0: what is written twice is the same bytes.
std::string dataset_bits(const fs::path& file) {
  const auto h5 = Hdf5File::open(file);
  std::vector<std::string> datasets;
  collect_datasets(*h5, "/", datasets);
  std::ostringstream out;
  for (const auto& name : datasets) {
    out << name << '\n';
    if (*h5->text_attribute(name, "unit") == "text") {
      const auto texts = h5->read_texts(name);
      for (const auto& text : *texts) out << text.size() << ':' << text << '\n';
    } else {
      const auto data = h5->read(name);
      for (const auto size : data->shape) out << size << ' ';
      for (const double value : data->values) out << std::bit_cast<std::uint64_t>(value) << ' ';
    }
  }
  return out.str();
}

TEST_F(CampaignResultsFile, GivesBackWhatWasWritten) {
  auto results = test::example_results();
  for (auto& burst : results.bursts)
    burst.coarse_graining = burst.dem_particles = 1.0;  // NaN equals nothing: see the next test

  ASSERT_TRUE(write_results(results, file()));
  const auto read = read_results(file());

  ASSERT_TRUE(read) << read.error().message;
  EXPECT_TRUE(*read == results);
}

TEST_F(CampaignResultsFile, KeepsEveryBitOfAwkwardNumbersAndTexts) {
  const auto results = test::awkward_results();
  ASSERT_TRUE(write_results(results, file()));

  const auto read = read_results(file());
  ASSERT_TRUE(read) << read.error().message;
  ASSERT_TRUE(write_results(*read, folder_ / "again.h5"));

  EXPECT_EQ(dataset_bits(file()), dataset_bits(folder_ / "again.h5"));
  EXPECT_EQ(read->provenance, results.provenance);
  EXPECT_EQ(read->timeline, results.timeline);
  EXPECT_EQ(read->core_use, results.core_use);
  EXPECT_EQ(read->choices, results.choices);
  EXPECT_EQ(read->pbm, results.pbm);
  EXPECT_EQ(read->sizes, results.sizes);
  EXPECT_EQ(read->rates.at(0), results.rates.at(0));
  EXPECT_EQ(read->rates.at(1).burst, 12345);
  EXPECT_EQ(read->bursts.at(0).dem_particles, std::numeric_limits<double>::infinity());
  EXPECT_EQ(read->bursts.at(0).d50, 5e-324);
  EXPECT_TRUE(std::isnan(read->bursts.at(1).d50));
  EXPECT_TRUE(std::signbit(read->bursts.at(1).process_start));
}

TEST_F(CampaignResultsFile, HoldsACampaignThatNeverBegan) {
  const CampaignResults nothing;

  ASSERT_TRUE(write_results(nothing, file()));
  const auto read = read_results(file());

  ASSERT_TRUE(read) << read.error().message;
  EXPECT_TRUE(*read == nothing);
}

TEST_F(CampaignResultsFile, HasExactlyTheDatasetsOfTheSchemaWithUnitDescriptionAndShape) {
  ASSERT_TRUE(write_results(test::awkward_results(), file()));
  const auto h5 = Hdf5File::open(file());
  ASSERT_TRUE(h5);

  std::vector<std::string> datasets;
  collect_datasets(*h5, "/", datasets);
  std::map<std::string, const results_schema::Dataset*> schema;
  for (const auto& dataset : results_schema::kAll) schema[std::string(dataset.name)] = &dataset;
  EXPECT_EQ(schema.size(), results_schema::kAll.size()) << "two datasets with one name";

  std::set<std::string> seen;
  for (const auto& name : datasets) {
    ASSERT_TRUE(schema.contains(general_name(name))) << name;
    const auto& dataset = *schema[general_name(name)];
    seen.insert(general_name(name));
    EXPECT_EQ(h5->text_attribute(name, "unit").value_or("none"), dataset.unit) << name;
    EXPECT_EQ(h5->text_attribute(name, "description").value_or("none"), dataset.description) << name;
    EXPECT_FALSE(dataset.description.empty()) << name;
  }
  EXPECT_EQ(seen.size(), schema.size());
  EXPECT_EQ(h5->text_attribute("/", "format").value_or("none"), "granary-results-1");
  EXPECT_EQ(h5->read("/sizes/compartments")->shape, (std::vector<std::size_t>{4, 3, 7}));
  EXPECT_EQ(h5->read("/sizes/edge")->shape, (std::vector<std::size_t>{8}));
  EXPECT_EQ(h5->read("/rates/0001/collision_rate")->shape, (std::vector<std::size_t>{2, 2}));
  EXPECT_EQ(h5->read("/dem/speed")->shape, (std::vector<std::size_t>{6, 9}));
}

/// The rows "| `/pbm/time` | (T) | s | ... |" of docs/results_format.md as name -> "shape|unit".
std::map<std::string, std::string> documented() {
  std::ifstream in(GRANARY_SOURCE_DIR "/docs/results_format.md");
  std::map<std::string, std::string> rows;
  for (std::string line; std::getline(in, line);) {
    if (line == "## Results of a sweep") break;  // another file
    if (!line.starts_with("| `/")) continue;
    std::vector<std::string> cells;
    std::istringstream row(line.substr(1));
    for (std::string cell; std::getline(row, cell, '|');)
      cells.push_back(cell.size() > 2 ? cell.substr(1, cell.size() - 2) : "");
    const bool first =
        rows.emplace(cells.at(0).substr(1, cells.at(0).size() - 2), cells.at(1) + "|" + cells.at(2)).second;
    EXPECT_TRUE(first) << line;
  }
  return rows;
}

TEST(ResultsFormatPage, NamesEveryDatasetWithItsShapeAndUnitAndNoOther) {
  const auto page = documented();

  std::map<std::string, std::string> schema;
  for (const auto& dataset : results_schema::kAll) {
    std::string shape = "(";
    for (const char c : dataset.shape) shape += c == ' ' ? std::string(", ") : std::string(1, c);
    schema[std::string(dataset.name)] = shape + ")|" + std::string(dataset.unit);
  }

  EXPECT_EQ(page, schema);
}

TEST_F(CampaignResultsFile, RefusesSeriesThatDoNotFitTogetherAndNamesThem) {
  auto results = test::example_results();
  results.pbm.d50.pop_back();

  const auto status = write_results(results, file());

  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().exit, Exit::internal);
  EXPECT_THAT(status.error().message, HasSubstr("/pbm/d50 has"));
  EXPECT_THAT(status.error().message, HasSubstr("/pbm/time has"));
  EXPECT_FALSE(fs::exists(file()));
}

TEST_F(CampaignResultsFile, RefusesARowOfAnotherLength) {
  for (const int which : {0, 1, 2, 3}) {
    auto results = test::awkward_results();
    if (which == 0) results.pbm.liquid[4].push_back(1.0);
    if (which == 1) results.sizes.compartments[1][2].pop_back();
    if (which == 2) results.sizes.compartments[3].pop_back();
    if (which == 3) results.rates[0].collision_rate[1].pop_back();
    EXPECT_FALSE(write_results(results, file())) << which;
  }
}

TEST_F(CampaignResultsFile, RefusesRatesOfOneBurstTwice) {
  auto results = test::awkward_results();
  results.rates[1].burst = results.rates[0].burst;

  EXPECT_FALSE(write_results(results, file()));
}

TEST_F(CampaignResultsFile, KeepsTheOldFileWhenTheDiskIsFull) {
  ASSERT_TRUE(write_text_atomically(file(), "what was there"));
  fs::create_symlink("/dev/full", folder_ / "results.h5.new");  // what is written beside the file meets a full disk

  const auto status = write_results(test::example_results(), file());

  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().exit, Exit::task_failed);
  EXPECT_THAT(status.error().message, HasSubstr("results.h5"));
  EXPECT_THAT(status.error().message, HasSubstr("No space left on device"));
  EXPECT_EQ(*read_text(file()), "what was there");
}

TEST_F(CampaignResultsFile, SaysWhatAForeignFileIs) {
  EXPECT_THAT(read_results(file()).error().message, HasSubstr("no such file"));

  ASSERT_TRUE(write_text_atomically(file(), "text"));
  EXPECT_THAT(read_results(file()).error().message, HasSubstr("no HDF5 file"));

  ASSERT_TRUE(Hdf5File::create(file())->attribute("/", "format", "granary-pbm-out-1"));
  EXPECT_THAT(read_results(file()).error().message,
              HasSubstr("\"granary-pbm-out-1\"; \"granary-results-1\" is wanted"));
}

TEST_F(CampaignResultsFile, SaysWhichDatasetIsMissingOrMisshapen) {
  const auto spoil = [&](const std::string& name, const DataArray& data) {
    EXPECT_TRUE(write_results(test::awkward_results(), file()));
    EXPECT_TRUE(Hdf5File::open_to_append(file())->write(name, data, "1", "spoilt"));
    return read_results(file());
  };

  EXPECT_THAT(spoil("/pbm/porosity", {{2, 3}, std::vector<double>(6)}).error().message,
              HasSubstr("/pbm/porosity has 2 where /pbm/time has 5 (T)"));
  EXPECT_THAT(spoil("/pbm/porosity", {{5}, std::vector<double>(5)}).error().message,
              HasSubstr("/pbm/porosity has 1 axes"));
  EXPECT_THAT(spoil("/summary/ended", {{1}, {1.0}}).error().message, HasSubstr("/summary/ended"));
  EXPECT_FALSE(spoil("/rates/0007/diameter", {{1}, {1.0}}));
  EXPECT_FALSE(spoil("/rates/last/diameter", {{1}, {1.0}}));
}

TEST_F(CampaignResultsFile, SaysThatACutFileWasCut) {
  ASSERT_TRUE(write_results(test::example_results(), file()));
  const std::string whole = *read_text(file());

  for (const double share : {0.1, 0.5, 0.9, 0.999}) {
    ASSERT_TRUE(write_text_atomically(
        file(), whole.substr(0, static_cast<std::size_t>(share * static_cast<double>(whole.size())))));
    EXPECT_FALSE(read_results(file())) << share;
  }
}

TEST(CoreUse, CountsOverlapsOnceInTimeAndEachCoreInCoreSeconds) {
  const std::vector<TimelineEntry> timeline{
      {"a", "dem", 1, {0, 1}, 0.0, 4.0},      {"m", "monitor", 1, {}, 0.0, 4.0},
      {"b", "pbm", 1, {0}, 5.0, 7.0},         {"e1", "estimation", 1, {1}, 5.0, 6.0},
      {"e2", "estimation", 1, {2}, 5.5, 7.0}, {"x", "sorting", 1, {3}, 8.0, 9.0}};

  const CoreUse use = core_use(timeline, 4, 10.0);

  const std::vector<KindUse> kinds{
      {"dem", 4.0, 8.0}, {"pbm", 2.0, 2.0}, {"monitor", 4.0, 0.0}, {"estimation", 2.0, 2.5}, {"other", 1.0, 1.0}};
  EXPECT_EQ(use.kinds, kinds);
  EXPECT_DOUBLE_EQ(use.idle, 3.0);
  EXPECT_DOUBLE_EQ(use.busy_share, 13.5 / 40.0);
}

TEST(CoreUse, IsZeroWhenNothingRan) {
  const CoreUse use = core_use({}, 2, 0.0);

  EXPECT_TRUE(use.kinds.empty());
  EXPECT_EQ(use.busy_share, 0.0);
  EXPECT_EQ(use.idle, 0.0);
}

}  // namespace
}  // namespace granary
