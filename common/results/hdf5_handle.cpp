#include "common/results/hdf5_handle.hpp"

#include <algorithm>
#include <functional>
#include <numeric>

namespace granary {
namespace {

constexpr hsize_t kMostValues = hsize_t{1} << 31;  // nothing of ours comes near, and a product of two does not overflow
constexpr hsize_t kBestPacking = 1032;             // of deflate

}  // namespace

Handle text_type() {
  Handle type(H5Tcopy(H5T_C_S1), H5Tclose);
  H5Tset_size(type, H5T_VARIABLE);
  H5Tset_cset(type, H5T_CSET_UTF8);
  return type;
}

bool exists(hid_t file, const std::string& name) {
  if (name == "/" || name.empty()) return true;
  // Each link on the way must exist: HDF5 does not look past a missing one.
  for (std::size_t slash = name.find('/', 1); slash != std::string::npos; slash = name.find('/', slash + 1))
    if (H5Lexists(file, name.substr(0, slash).c_str(), H5P_DEFAULT) <= 0) return false;
  return H5Lexists(file, name.c_str(), H5P_DEFAULT) > 0;
}

Handle open_dataset(hid_t file, const std::string& name) {
  if (!exists(file, name)) return {-1, H5Dclose};
  return {H5Dopen2(file, name.c_str(), H5P_DEFAULT), H5Dclose};
}

std::vector<hsize_t> shape_of(hid_t dataset) {
  const Handle space(H5Dget_space(dataset), H5Sclose);
  std::vector<hsize_t> dims(static_cast<std::size_t>(std::max(0, H5Sget_simple_extent_ndims(space))));
  if (!dims.empty()) H5Sget_simple_extent_dims(space, dims.data(), nullptr);
  return dims;
}

/// The product of the dims; none beyond what anything of ours has.
std::optional<std::size_t> count_of(const std::vector<hsize_t>& dims) {
  hsize_t n = 1;
  for (const hsize_t d : dims) {
    if (d > kMostValues || n * d > kMostValues) return std::nullopt;
    n *= d;
  }
  return n;
}

/// Whether the values lie in this file, as many as the dataset claims to have (a few bytes could claim terabytes).
bool stored_as_claimed(hid_t dataset) {
  const auto n = count_of(shape_of(dataset));
  if (!n) return false;
  if (*n == 0) return true;
  const Handle properties(H5Dget_create_plist(dataset), H5Pclose), type(H5Dget_type(dataset), H5Tclose);
  const bool packed = H5Pget_nfilters(properties) > 0;
  const hsize_t stored = H5Dget_storage_size(dataset) / H5Tget_size(type) * (packed ? kBestPacking : 1);
  if (*n > stored || H5Pget_external_count(properties) != 0) return false;
  const H5D_layout_t layout = H5Pget_layout(properties);
  if (layout != H5D_CHUNKED) return layout == H5D_CONTIGUOUS || layout == H5D_COMPACT;
  std::vector<hsize_t> chunk(shape_of(dataset).size());
  if (H5Pget_chunk(properties, static_cast<int>(chunk.size()), chunk.data()) < 0) return false;
  const auto in_chunk = count_of(chunk);
  return in_chunk && *in_chunk <= stored;
}

bool holds(hid_t dataset, std::initializer_list<H5T_class_t> kinds) {
  const Handle type(H5Dget_type(dataset), H5Tclose);
  const H5T_class_t kind = H5Tget_class(type);
  return std::find(kinds.begin(), kinds.end(), kind) != kinds.end() && H5Tget_size(type) <= 16;
}

/// A dataset of numbers that can be read without harm; not good otherwise.
Handle open_numbers(hid_t file, const std::string& name) {
  Handle dataset = open_dataset(file, name);
  const bool fine = dataset.good() && holds(dataset, {H5T_INTEGER, H5T_FLOAT}) && stored_as_claimed(dataset);
  return fine ? std::move(dataset) : Handle(-1, H5Dclose);
}

/// The rows [row, row+1) of a dataset as a selection of its file space.
Handle row_selection(hid_t dataset, hsize_t row, const std::vector<hsize_t>& dims) {
  Handle space(H5Dget_space(dataset), H5Sclose);
  std::vector<hsize_t> start(dims.size(), 0), count = dims;
  start[0] = row;
  count[0] = 1;
  H5Sselect_hyperslab(space, H5S_SELECT_SET, start.data(), nullptr, count.data(), nullptr);
  return space;
}

std::size_t row_length(const std::vector<hsize_t>& dims) {
  return static_cast<std::size_t>(std::accumulate(dims.begin() + 1, dims.end(), hsize_t{1}, std::multiplies<>()));
}

/// An attribute with a single value; not good otherwise.
Handle open_attribute(hid_t file, const std::string& name, const std::string& key) {
  Handle attribute(H5Aopen_by_name(file, name.c_str(), key.c_str(), H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  if (!attribute.good()) return attribute;
  const Handle space(H5Aget_space(attribute), H5Sclose);
  return H5Sget_simple_extent_npoints(space) == 1 ? std::move(attribute) : Handle(-1, H5Aclose);
}

}  // namespace granary
