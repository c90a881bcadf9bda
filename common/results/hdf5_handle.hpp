// Ids of HDF5 that close themselves, and a careful look at what they stand for before anything is read. Only for the
// .cpp files of common/results.
#pragma once

#include <hdf5.h>

#include <initializer_list>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace granary {

/// An HDF5 id with the function that closes it.
class Handle {
 public:
  Handle(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) {}
  Handle(Handle&& other) noexcept : id_(std::exchange(other.id_, -1)), close_(other.close_) {}
  Handle& operator=(Handle&&) = delete;
  ~Handle() {
    if (id_ >= 0) close_(id_);
  }
  operator hid_t() const { return id_; }  // NOLINT: stands for the id
  bool good() const { return id_ >= 0; }

 private:
  hid_t id_;
  herr_t (*close_)(hid_t);
};

/// Texts of any length, UTF-8.
Handle text_type();
bool exists(hid_t file, const std::string& name);
/// Not good if there is none.
Handle open_dataset(hid_t file, const std::string& name);
std::vector<hsize_t> shape_of(hid_t dataset);
/// The product of the dims; none beyond what anything of ours has.
std::optional<std::size_t> count_of(const std::vector<hsize_t>& dims);
/// Whether the values lie in this file, as many as the dataset claims to have (a few bytes could claim terabytes).
bool stored_as_claimed(hid_t dataset);
/// Whether its values are of one of these kinds.
bool holds(hid_t dataset, std::initializer_list<H5T_class_t> kinds);
/// A dataset of numbers that can be read without harm; not good otherwise.
Handle open_numbers(hid_t file, const std::string& name);
/// The rows [row, row+1) of a dataset as a selection of its file space.
Handle row_selection(hid_t dataset, hsize_t row, const std::vector<hsize_t>& dims);
std::size_t row_length(const std::vector<hsize_t>& dims);
/// An attribute with a single value; not good otherwise.
Handle open_attribute(hid_t file, const std::string& name, const std::string& key);

}  // namespace granary
