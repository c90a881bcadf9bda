#include "controller/campaign/estimation_targets.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "common/units.hpp"
#include "controller/campaign/data_file.hpp"
#include "controller/campaign/sections.hpp"

namespace granary::campaign {
namespace {

namespace fs = std::filesystem;
using estimation::kEverywhere;
using estimation::kOutlet;
using estimation::Quantity;
using estimation::Target;
using json::Range;

std::vector<std::string> names_of_quantities() {
  std::vector<std::string> names;
  for (const Quantity quantity : estimation::kQuantities) names.emplace_back(estimation::name_of(quantity));
  return names;
}

/// A standard deviation: of the value, or a share of it.
struct Deviation {
  double value = 0.0;
  bool relative = false;
  double of(double value_of_datum) const { return relative ? value * std::abs(value_of_datum) : value; }
};

/// Reads one item of "targets".
class TargetReader {
 public:
  TargetReader(json::Reader& reader, const Campaign& campaign, Estimation& estimation)
      : reader_(reader), campaign_(campaign), estimation_(estimation) {}

  void read() {
    experiment_ = &read_experiment();
    target_.experiment = experiment_->name;
    const std::string quantity = reader_.choice("quantity", names_of_quantities());
    for (const Quantity one : estimation::kQuantities)
      if (quantity == estimation::name_of(one)) target_.quantity = one;
    target_.compartment = read_compartment();
    unit_ = unit_of(target_.quantity, target_.compartment);
    target_.weight = reader_.number_or("weight", 1.0, Range::positive());
    target_.held_out = reader_.boolean_or("held_out", false);
    if (reader_.has("error")) error_ = read_error();
    source_ = reader_.text_or("file", "");
    if (source_.empty())
      read_written();
    else
      read_file();
    reader_.done();
  }

 private:
  bool is_distribution() const { return target_.quantity == Quantity::distribution; }

  const Estimation::Experiment& read_experiment() {
    const Estimation::Experiment& first = estimation_.experiments.front();
    if (!reader_.has("experiment")) return first;
    const std::string name = reader_.text("experiment");
    std::vector<std::string> names;
    for (const Estimation::Experiment& one : estimation_.experiments) {
      if (one.name == name) return one;
      names.push_back(one.name);
    }
    const std::string near = json::did_you_mean(name, names);
    reader_.problem("experiment", "there is no such experiment.",
                    near.empty() ? "See /estimation/experiments." : "Did you mean \"" + near + "\"?");
    return first;
  }

  int read_compartment() {
    const pbm::Compartments& row = experiment_->balance.compartments;
    const json::Value* written = reader_.raw("compartment");
    if (written == nullptr) return row.residence_time ? kOutlet : kEverywhere;
    if (written->is_string() && written->as_string() == "all") return kEverywhere;
    if (written->is_string() && written->as_string() == "outlet") {
      if (!row.residence_time)
        reader_.problem("compartment", "nothing flows out of this process.", "Take \"all\" or a number.");
      return kOutlet;
    }
    if (!written->is_integer() || written->as_integer() < 1 || written->as_integer() > row.count) {
      reader_.problem("compartment", fmt::format("it must be 1 to {}, \"all\" or \"outlet\".", row.count));
      return kEverywhere;
    }
    return static_cast<int>(written->as_integer()) - 1;
  }

  /// "5 %" of the value; else as the value itself.
  Deviation read_error() {
    const json::Value* written = reader_.raw("error");
    if (written->is_string() && written->as_string().find('%') != std::string::npos) {
      const auto share = to_si(written->as_string(), "1");
      if (is_distribution())
        reader_.problem("error", "for a distribution it is that of each share, a number.", "For example 0.01.");
      else if (!share || !(*share > 0.0))
        reader_.problem("error", "it must be a share of the value such as \"5 %\", > 0.");
      else
        return {*share, true};
      return {1.0, true};
    }
    return {
        unit_ == "1" ? reader_.number("error", Range::positive()) : reader_.quantity("error", unit_, Range::positive()),
        false};
  }

  /// The datum is complete but for what the campaign must know of it.
  void add(const std::string& where, const std::string& row) {
    const double last = experiment_->balance.end_time;
    if (!(target_.time > 0.0) || target_.time > last) {
      reader_.problem(where,
                      fmt::format("{}{:g} s is not within the process, which ends at {:g} s.", row, target_.time, last),
                      "See /process/duration; of a file, \"from\" and \"to\" take a part.");
    } else if (!(target_.error > 0.0)) {
      reader_.problem(where == "at" ? "error" : where, row + "of this value it is not > 0.",
                      "Give an absolute \"error\".");
    } else {
      estimation_.targets.push_back(target_);
      estimation_.sources.push_back(source_);
    }
  }

  void read_written() {
    target_.time = reader_.quantity("at", "s", Range::positive());
    if (!reader_.has("error"))
      reader_.problem("error", "it is missing: the standard deviation of the datum.", "For example \"5 %\".");
    if (is_distribution()) {
      target_.edges = reader_.quantities("edges", "m", Range::not_negative());
      target_.shares = reader_.numbers("shares", Range::not_negative());
      target_.error = error_.value_or(Deviation{1.0, false}).value;
      if (const auto fault = fault_of_distribution(); !fault.empty()) return reader_.problem("shares", fault);
    } else {
      target_.value = unit_ == "1" ? reader_.number("value", Range::not_negative())
                                   : reader_.quantity("value", unit_, Range::positive());
      has_value_ = reader_.has("value") && (unit_ == "1" || target_.value > 0.0);
      target_.error = error_.value_or(Deviation{1.0, false}).of(target_.value);
    }
    if (reader_.has("at") && target_.time > 0.0 && (is_distribution() || has_value_)) add("at", "");
  }

  std::string fault_of_distribution() const {
    if (target_.shares.empty() || target_.edges.size() != target_.shares.size() + 1)
      return fmt::format("there are {} shares and {} edges; there must be one edge more than shares.",
                         target_.shares.size(), target_.edges.size());
    if (!std::is_sorted(target_.edges.begin(), target_.edges.end(), std::less_equal<>())) return "the edges must rise.";
    const double sum = std::accumulate(target_.shares.begin(), target_.shares.end(), 0.0);
    if (sum > 1.02) return fmt::format("they add up to {:g}; shares of the volume add up to 1 at most.", sum);
    return "";
  }

  void read_file() {
    from_ = reader_.quantity_or("from", -1e300, "s");
    to_ = reader_.quantity_or("to", 1e300, "s");
    every_ = reader_.quantity_or("every", 0.0, "s", Range::not_negative());
    const fs::path file = campaign_.folder / source_;
    const bool h5 = file.extension() == ".h5" || file.extension() == ".hdf5";
    if (!h5 && reader_.has("dataset"))
      return reader_.problem("dataset", "only files of HDF5 (.h5, .hdf5) have datasets.");
    if (h5 && reader_.has("column"))
      return reader_.problem("column", "files of HDF5 have datasets.", R"(Name one: "dataset": "/pbm/outlet_d50".)");
    const std::size_t before = estimation_.targets.size();
    const Status done = h5 ? (is_distribution() ? distributions_of_h5(file) : values_of_h5(file))
                           : (is_distribution() ? distributions_of_csv(file) : values_of_csv(file));
    if (!done)
      return reader_.problem("file", without_folder(done.error().message, campaign_.folder),
                             "See docs/workflow_format.md#files-of-data.");
    if (estimation_.targets.size() == before)
      reader_.problem("file", "it has no datum to fit to.", "See its times, and \"from\" and \"to\".");
  }

  /// Of rows in rising order of time, those asked for.
  bool is_wanted(double time) {
    if (std::isnan(time) || time < from_ || time > to_ || time < last_taken_ + every_ * (1.0 - 1e-9)) return false;
    last_taken_ = time;
    return true;
  }

  std::string name_of_row(std::size_t row) const { return fmt::format("datum {} of {}: ", row + 1, source_); }

  /// The name of the column of values: that of the quantity, if no other is given.
  std::string own_column() const {
    return reader_.text_or("column", is_distribution() ? "share" : estimation::name_of(target_.quantity));
  }

  Status values_of_csv(const fs::path& file) {
    GRANARY_TRY(const CsvFile csv, CsvFile::read(file));
    const std::string own = own_column();
    const std::string errors = csv.has(own + "_error") ? own + "_error" : "error";
    GRANARY_TRY(const Column time, csv.column("time", "s"));
    GRANARY_TRY(const Column value, csv.column(own, unit_));
    std::optional<Column> error;
    if (csv.has(errors)) {
      GRANARY_TRY(error, csv.column(errors, unit_, true));
    } else if (!error_) {
      return Error{fmt::format("{}: there is neither a column \"{}_error\" or \"error\" nor a setting \"error\".",
                               file.string(), own)};
    }
    for (std::size_t row = 0; row < time.values.size(); ++row) {
      target_.time = time.values[row];
      target_.value = value.values[row];
      if (std::isnan(target_.value) || !is_wanted(target_.time)) continue;
      target_.error =
          error ? Deviation{error->values[row], error->percent}.of(target_.value) : error_->of(target_.value);
      add("file", name_of_row(row));
    }
    return {};
  }

  /// Rows "from, to, share" of one distribution after the other, each with its time.
  Status distributions_of_csv(const fs::path& file) {
    GRANARY_TRY(const CsvFile csv, CsvFile::read(file));
    GRANARY_TRY(const Column times, csv.column("time", "s"));
    GRANARY_TRY(const Column from, csv.column("from", "m"));
    GRANARY_TRY(const Column to, csv.column("to", "m"));
    GRANARY_TRY(const Column share, csv.column(own_column(), "1"));
    const auto& time = times.values;
    for (std::size_t row = 0; row < time.size();) {
      target_.edges = {from.values[row]};
      target_.shares.clear();
      const std::size_t first = row;
      for (; row < time.size() && time[row] == time[first]; ++row) {
        if (from.values[row] != target_.edges.back())
          return Error{
              fmt::format("{}: datum {}: each class must begin where the one before it ends.", file.string(), row + 1)};
        target_.edges.push_back(to.values[row]);
        target_.shares.push_back(share.values[row]);
      }
      GRANARY_CHECK(add_distribution(file, time[first], first));
      if (row == first) ++row;  // a time that is no number
    }
    return {};
  }

  Status add_distribution(const fs::path& file, double time, std::size_t row) {
    if (!error_) return Error{file.string() + ": \"error\" is missing: the standard deviation of each share."};
    if (!is_wanted(time)) return {};
    const double total = std::accumulate(target_.shares.begin(), target_.shares.end(), 0.0);
    if (total == 0.0) return {};  // nothing was there
    if (const auto fault = fault_of_distribution(); !fault.empty())
      return Error{fmt::format("{}: the distribution at {:g} s: {}", file.string(), time, fault)};
    target_.time = time;
    target_.error = error_->value;
    add("file", name_of_row(row));
    return {};
  }

  /// The dataset, and its times from "time" beside it.
  Result<std::pair<Dataset, std::vector<double>>> read_h5(const fs::path& file, std::string& folder) {
    const std::string name = reader_.text_or("dataset", "");
    if (name.empty() || name[0] != '/')
      return Error{R"("dataset" is missing, such as "/pbm/outlet_d50": whose values are the data.)"};
    folder = name.substr(0, name.rfind('/'));
    GRANARY_TRY(Dataset values, read_dataset(file, name, unit_));
    GRANARY_TRY(const Dataset times, read_dataset(file, folder + "/time", "s"));
    const std::size_t rows = times.values.size();
    if (values.shape.empty() || values.shape[0] != rows || rows == 0)
      return Error{fmt::format("{}: {} has {} rows, and {}/time beside it has {}.", file.string(), name,
                               values.shape.empty() ? 0 : values.shape[0], folder, rows)};
    return std::pair{std::move(values), times.values};
  }

  Status values_of_h5(const fs::path& file) {
    std::string folder;
    GRANARY_TRY(const auto data, read_h5(file, folder));
    const auto& [values, times] = data;
    const std::size_t width = values.values.size() / times.size();
    if (values.shape.size() > 2 || (width > 1 && target_.compartment == kEverywhere))
      return Error{fmt::format("{}: of a value for each compartment (a row has {}), \"compartment\" must say which.",
                               file.string(), width)};
    const std::size_t at = width == 1                       ? 0
                           : target_.compartment == kOutlet ? width - 1
                                                            : static_cast<std::size_t>(target_.compartment);
    if (at >= width) return Error{fmt::format("{}: it has {} compartments.", file.string(), width)};
    const std::string errors = reader_.text_or("dataset", "") + "_error";
    std::optional<Dataset> error;
    if (!error_) {
      if (!has_dataset(file, errors))
        return Error{fmt::format("{}: there is neither {} nor a setting \"error\".", file.string(), errors)};
      GRANARY_TRY(error, read_dataset(file, errors, unit_));
      if (error->values.size() != values.values.size())
        return Error{fmt::format("{}: {} is of another size than its data.", file.string(), errors)};
    }
    for (std::size_t row = 0; row < times.size(); ++row) {
      target_.value = values.values[row * width + at];
      if (std::isnan(target_.value) || !is_wanted(times[row])) continue;
      target_.time = times[row];
      target_.error = error ? error->values[row * width + at] : error_->of(target_.value);
      add("file", name_of_row(row));
    }
    return {};
  }

  Status distributions_of_h5(const fs::path& file) {
    std::string folder;
    GRANARY_TRY(const auto data, read_h5(file, folder));
    GRANARY_TRY(const Dataset edge, read_dataset(file, folder + "/edge", "m"));
    const auto& [values, times] = data;
    const std::size_t width = values.values.size() / times.size();
    if (values.shape.size() != 2) return Error{file.string() + ": shares must have the shape (times, classes)."};
    for (std::size_t row = 0; row < times.size(); ++row) {
      target_.edges = edge.values;
      const auto first = values.values.begin() + static_cast<std::ptrdiff_t>(row * width);
      target_.shares.assign(first, first + static_cast<std::ptrdiff_t>(width));
      GRANARY_CHECK(add_distribution(file, times[row], row));
    }
    return {};
  }

  json::Reader& reader_;
  const Campaign& campaign_;
  Estimation& estimation_;
  const Estimation::Experiment* experiment_ = nullptr;
  Target target_;
  std::string source_;  ///< the file, or ""
  std::string unit_;
  bool has_value_ = false;
  std::optional<Deviation> error_;
  double from_ = -1e300, to_ = 1e300, every_ = 0.0, last_taken_ = -1e300;  ///< [s]
};

}  // namespace

void read_targets(json::Reader& section, const Campaign& campaign, Estimation& estimation) {
  auto items = section.items("targets");
  for (json::Reader& item : items) TargetReader(item, campaign, estimation).read();
  if (items.empty() && (!section.has("targets") || section.raw("targets")->is_array()))
    section.problem("targets", "there is none.",
                    R"(Add for example {"quantity": "d50", "at": "60 s", "value": "85 um", "error": "5 %"}.)");
  const bool all_held_out =
      !estimation.targets.empty() && std::all_of(estimation.targets.begin(), estimation.targets.end(),
                                                 [](const Target& target) { return target.held_out; });
  if (all_held_out) section.problem("targets", "all of them are held out: there is nothing to fit to.");
}

}  // namespace granary::campaign
