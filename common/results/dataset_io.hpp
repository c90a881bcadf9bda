// Members of plain structs <-> datasets of one HDF5 file, as common/results/schema.hpp describes them.
// DatasetWriter and DatasetReader have the same members, so that one list of (dataset, member) serves both directions.
// Both keep the first error and do nothing after it: ask status() at the end.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "common/results/hdf5_file.hpp"
#include "common/results/schema.hpp"

namespace granary {

/// The sizes that the letters of "T X" stand for, learned as datasets pass.
class ShapeLetters {
 public:
  /// Nothing, or how `shape` contradicts the dataset's letters: "/pbm/d50 has 4 where /pbm/time has 5 (T)".
  std::string contradiction(const results_schema::Dataset& dataset, const std::vector<std::size_t>& shape);
  void forget() { known_.clear(); }

 private:
  struct Known {
    std::size_t size;
    std::string from;
  };
  std::map<std::string, Known, std::less<>> known_;
};

class DatasetWriter {
 public:
  explicit DatasetWriter(Hdf5File& file) : file_(file) {}

  template <class T>
  void scalar(const results_schema::Dataset& dataset, const T& value) {
    list(dataset, std::vector<T>{value});
  }

  void list(const results_schema::Dataset& dataset, const std::vector<double>& values);
  void list(const results_schema::Dataset& dataset, const std::vector<std::int64_t>& values);
  void list(const results_schema::Dataset& dataset, const std::vector<std::string>& values);
  void rows(const results_schema::Dataset& dataset, const std::vector<std::vector<double>>& values);
  void tables(const results_schema::Dataset& dataset, const std::vector<std::vector<std::vector<double>>>& values);

  /// One member of every item.
  template <class Item, class T>
  void column(const results_schema::Dataset& dataset, const std::vector<Item>& items, T Item::*member) {
    std::vector<T> values;
    for (const Item& item : items) values.push_back(item.*member);
    list(dataset, values);
  }
  void list(const results_schema::Dataset& dataset,
            const std::vector<std::vector<std::int64_t>>& values);  ///< texts "0,1"

  /// The group that NNNN stands for from here on; its letters are its own.
  void enter(std::int64_t number);

  const Status& status() const { return status_; }

 private:
  bool fits(const results_schema::Dataset& dataset, const std::vector<std::size_t>& shape);
  void keep(Status status);

  Hdf5File& file_;
  ShapeLetters letters_;
  std::string group_ = "NNNN";
  Status status_;
};

class DatasetReader {
 public:
  DatasetReader(const Hdf5File& file, std::string name) : file_(file), name_(std::move(name)) {}

  template <class T>
  void scalar(const results_schema::Dataset& dataset, T& value) {
    std::vector<T> values;
    list(dataset, values);
    if (!values.empty()) value = std::move(values.front());
  }

  void list(const results_schema::Dataset& dataset, std::vector<double>& values);
  void list(const results_schema::Dataset& dataset, std::vector<std::int64_t>& values);
  void list(const results_schema::Dataset& dataset, std::vector<std::string>& values);
  void rows(const results_schema::Dataset& dataset, std::vector<std::vector<double>>& values);
  void tables(const results_schema::Dataset& dataset, std::vector<std::vector<std::vector<double>>>& values);

  template <class Item, class T>
  void column(const results_schema::Dataset& dataset, std::vector<Item>& items, T Item::*member) {
    std::vector<T> values;
    list(dataset, values);
    items.resize(values.size());
    for (std::size_t i = 0; i < items.size(); ++i) items[i].*member = std::move(values[i]);
  }
  void list(const results_schema::Dataset& dataset, std::vector<std::vector<std::int64_t>>& values);

  void enter(std::int64_t number);

  const Status& status() const { return status_; }

 private:
  /// The numbers if they have the dataset's shape; else nothing, and the error is kept.
  DataArray array(const results_schema::Dataset& dataset);
  bool fits(const results_schema::Dataset& dataset, const std::vector<std::size_t>& shape);
  void fail(std::string message);

  const Hdf5File& file_;
  std::string name_;
  ShapeLetters letters_;
  std::string group_ = "NNNN";
  Status status_;
};

}  // namespace granary
