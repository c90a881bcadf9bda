#include "common/results/hdf5_file.hpp"

#include <fmt/format.h>
#include <hdf5.h>

#include <algorithm>
#include <numeric>
#include <optional>
#include <utility>

#include "common/results/hdf5_handle.hpp"
#include "common/results/sealed_bytes.hpp"
#include "common/results/sealed_driver.hpp"

namespace granary {
namespace fs = std::filesystem;
namespace {

/// HDF5 prints its error stack by itself; our messages say it in one line. It must not tidy up at exit: after a failed
/// write (a full disk) that ends in a crash, while files that were written well are closed by then. And what a file
/// says must make it neither load a filter from a library nor open another file.
void set_up_library() {
  static const bool done = [] {
    return H5dont_atexit() >= 0 && H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr) >= 0 && H5PLset_loading_state(0) >= 0 &&
           H5Lunregister(H5L_TYPE_EXTERNAL) >= 0;
  }();
  (void)done;
}

Error failure(const fs::path& file, const std::string& what) {
  return {fmt::format("{}: {}", file.string(), what), Exit::task_failed};
}
Error cannot_read(const fs::path& file, const std::string& name) {
  return {fmt::format("{}: \"{}\" is missing or cannot be read. The file is damaged or of another kind.", file.string(),
                      name)};
}

Handle link_properties() {
  Handle properties(H5Pcreate(H5P_LINK_CREATE), H5Pclose);
  H5Pset_create_intermediate_group(properties, 1);
  return properties;
}

bool write_text_attribute(hid_t object, const char* key, std::string_view text) {
  if (H5Aexists(object, key) > 0) H5Adelete(object, key);
  const Handle type = text_type();
  const Handle space(H5Screate(H5S_SCALAR), H5Sclose);
  const Handle attribute(H5Acreate2(object, key, type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  const std::string copy(text);
  const char* pointer = copy.c_str();
  return attribute.good() && H5Awrite(attribute, type, &pointer) >= 0;
}

bool describe(hid_t object, std::string_view unit, std::string_view description) {
  return write_text_attribute(object, "unit", unit) && write_text_attribute(object, "description", description);
}

std::vector<hsize_t> dims_of(const std::vector<std::size_t>& shape) { return {shape.begin(), shape.end()}; }

Handle make_dataset(hid_t file, const std::string& name, hid_t type, hid_t space, hid_t properties) {
  if (exists(file, name)) H5Ldelete(file, name.c_str(), H5P_DEFAULT);
  const Handle links = link_properties();
  return {H5Dcreate2(file, name.c_str(), type, space, links, properties, H5P_DEFAULT), H5Dclose};
}

}  // namespace

Result<Hdf5File> Hdf5File::create(const fs::path& file) {
  set_up_library();
  const hid_t id = H5Fcreate(file.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
  if (id < 0) return failure(file, "cannot be made. Does its folder exist, may it be written, is there space?");
  return Hdf5File(id, file);
}

Result<Hdf5File> Hdf5File::open(const fs::path& file) {
  set_up_library();
  std::error_code ignored;
  if (!fs::exists(file, ignored)) return Error{file.string() + ": there is no such file."};
  if (SealedBytes::seems_sealed(file)) return open_sealed(file);
  const hid_t id = H5Fopen(file.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  if (id < 0) return Error{file.string() + ": is no HDF5 file, or was cut short."};
  return Hdf5File(id, file);
}

Result<Hdf5File> Hdf5File::open_to_append(const fs::path& file) {
  set_up_library();
  const hid_t id = H5Fopen(file.c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
  if (id < 0) return failure(file, "cannot be opened for writing: it is missing, no HDF5 file, or was cut short.");
  return Hdf5File(id, file);
}

Result<Hdf5File> Hdf5File::create_sealed(const fs::path& file) {
  set_up_library();
  GRANARY_TRY(SealedBytes bytes, SealedBytes::create(file));
  auto sealed = std::make_unique<SealedBytes>(std::move(bytes));
  const hid_t id = create_in(*sealed);
  if (id < 0) return failure(file, "cannot be made: HDF5 refuses.");
  return Hdf5File(id, file, std::move(sealed));
}

Result<Hdf5File> Hdf5File::open_sealed(const fs::path& file) {
  set_up_library();
  GRANARY_TRY(SealedBytes bytes, SealedBytes::open(file));
  auto sealed = std::make_unique<SealedBytes>(std::move(bytes));
  const hid_t id = open_in(*sealed);
  if (id < 0) return Error{file.string() + ": has a whole seal, but no HDF5 file under it."};
  return Hdf5File(id, file, std::move(sealed));
}

Hdf5File::Hdf5File(std::int64_t id, fs::path file, std::unique_ptr<SealedBytes> sealed)
    : sealed_(std::move(sealed)), id_(id), file_(std::move(file)) {}
Hdf5File::Hdf5File(Hdf5File&& other) noexcept
    : sealed_(std::move(other.sealed_)),
      id_(std::exchange(other.id_, -1)),
      file_(std::move(other.file_)),
      broken_(other.broken_) {}
Hdf5File& Hdf5File::operator=(Hdf5File&& other) noexcept {
  std::swap(sealed_, other.sealed_);
  std::swap(id_, other.id_);
  std::swap(file_, other.file_);
  std::swap(broken_, other.broken_);
  return *this;
}
Hdf5File::~Hdf5File() {
  if (id_ >= 0 && !broken_) H5Fclose(id_);
}

Error Hdf5File::failed_to_write(const std::string& name) {
  broken_ = true;
  return failure(file_, fmt::format("\"{}\" cannot be written. Is the disk full, or the file open elsewhere?", name));
}

Status Hdf5File::write(const std::string& name, const DataArray& data, std::string_view unit,
                       std::string_view description) {
  const auto dims = dims_of(data.shape);
  const Handle space(H5Screate_simple(static_cast<int>(dims.size()), dims.data(), nullptr), H5Sclose);
  const Handle dataset = make_dataset(id_, name, H5T_NATIVE_DOUBLE, space, H5P_DEFAULT);
  if (!dataset.good() || H5Dwrite(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, data.values.data()) < 0 ||
      !describe(dataset, unit, description))
    return failed_to_write(name);
  return {};
}

Status Hdf5File::write_integers(const std::string& name, const std::vector<std::int64_t>& values, std::string_view unit,
                                std::string_view description) {
  const hsize_t size = values.size();
  const Handle space(H5Screate_simple(1, &size, nullptr), H5Sclose);
  const Handle dataset = make_dataset(id_, name, H5T_NATIVE_INT64, space, H5P_DEFAULT);
  if (!dataset.good() || H5Dwrite(dataset, H5T_NATIVE_INT64, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()) < 0 ||
      !describe(dataset, unit, description))
    return failed_to_write(name);
  return {};
}

Status Hdf5File::write_texts(const std::string& name, const std::vector<std::string>& values,
                             std::string_view description) {
  const hsize_t size = values.size();
  const Handle type = text_type();
  const Handle space(H5Screate_simple(1, &size, nullptr), H5Sclose);
  const Handle dataset = make_dataset(id_, name, type, space, H5P_DEFAULT);
  std::vector<const char*> pointers;
  for (const auto& value : values) pointers.push_back(value.c_str());
  if (!dataset.good() || H5Dwrite(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, pointers.data()) < 0 ||
      !describe(dataset, "", description))
    return failed_to_write(name);
  return {};
}

Status Hdf5File::create_growing(const std::string& name, const std::vector<std::size_t>& row_shape,
                                std::string_view unit, std::string_view description) {
  std::vector<hsize_t> dims{0};
  dims.insert(dims.end(), row_shape.begin(), row_shape.end());
  auto most = dims;
  most[0] = H5S_UNLIMITED;
  auto chunk = dims;
  // A chunk of many short rows, or one long row: about 8 KB at least.
  chunk[0] = std::max<hsize_t>(1, 1024 / std::max<std::size_t>(1, row_length(dims)));
  const Handle space(H5Screate_simple(static_cast<int>(dims.size()), dims.data(), most.data()), H5Sclose);
  const Handle properties(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
  H5Pset_chunk(properties, static_cast<int>(chunk.size()), chunk.data());
  const Handle dataset = make_dataset(id_, name, H5T_NATIVE_DOUBLE, space, properties);
  if (!dataset.good() || !describe(dataset, unit, description)) return failed_to_write(name);
  return {};
}

Status Hdf5File::append_row(const std::string& name, const std::vector<double>& row) {
  const Handle dataset = open_dataset(id_, name);
  if (!dataset.good()) return failed_to_write(name);
  auto dims = shape_of(dataset);
  GRANARY_ASSERT(!dims.empty() && row.size() == row_length(dims), name);
  dims[0] += 1;
  if (H5Dset_extent(dataset, dims.data()) < 0) return failed_to_write(name);
  const Handle rows = row_selection(dataset, dims[0] - 1, dims);
  const hsize_t size = row.size();
  const Handle memory(H5Screate_simple(1, &size, nullptr), H5Sclose);
  if (H5Dwrite(dataset, H5T_NATIVE_DOUBLE, memory, rows, H5P_DEFAULT, row.data()) < 0) return failed_to_write(name);
  return {};
}

Status Hdf5File::truncate_rows(const std::string& name, std::size_t n_rows) {
  const Handle dataset = open_dataset(id_, name);
  if (!dataset.good()) return failed_to_write(name);
  auto dims = shape_of(dataset);
  if (dims.empty() || dims[0] <= n_rows) return {};
  dims[0] = n_rows;
  if (H5Dset_extent(dataset, dims.data()) < 0) return failed_to_write(name);
  return {};
}

namespace {
Handle open_or_make_object(hid_t file, const std::string& name) {
  if (exists(file, name)) return {H5Oopen(file, name.c_str(), H5P_DEFAULT), H5Oclose};
  const Handle links = link_properties();
  return {H5Gcreate2(file, name.c_str(), links, H5P_DEFAULT, H5P_DEFAULT), H5Gclose};
}
}  // namespace

Status Hdf5File::attribute(const std::string& name, const std::string& key, std::string_view text) {
  const Handle object = open_or_make_object(id_, name);
  if (!object.good() || !write_text_attribute(object, key.c_str(), text)) return failed_to_write(name + " @" + key);
  return {};
}

Status Hdf5File::attribute(const std::string& name, const std::string& key, double value) {
  const Handle object = open_or_make_object(id_, name);
  if (!object.good()) return failed_to_write(name);
  if (H5Aexists(object, key.c_str()) > 0) H5Adelete(object, key.c_str());
  const Handle space(H5Screate(H5S_SCALAR), H5Sclose);
  const Handle made(H5Acreate2(object, key.c_str(), H5T_NATIVE_DOUBLE, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  if (!made.good() || H5Awrite(made, H5T_NATIVE_DOUBLE, &value) < 0) return failed_to_write(name + " @" + key);
  return {};
}

bool Hdf5File::has(const std::string& name) const { return exists(id_, name); }

Result<DataArray> Hdf5File::read(const std::string& name) const {
  const Handle dataset = open_numbers(id_, name);
  if (!dataset.good()) return cannot_read(file_, name);
  const auto dims = shape_of(dataset);
  DataArray data{{dims.begin(), dims.end()}, std::vector<double>(*count_of(dims))};
  if (H5Dread(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, data.values.data()) < 0)
    return cannot_read(file_, name);
  return data;
}

Result<std::vector<std::size_t>> Hdf5File::shape(const std::string& name) const {
  const Handle dataset = open_numbers(id_, name);
  if (!dataset.good()) return cannot_read(file_, name);
  const auto dims = shape_of(dataset);
  return std::vector<std::size_t>(dims.begin(), dims.end());
}

Result<std::vector<double>> Hdf5File::read_row(const std::string& name, std::size_t row) const {
  const Handle dataset = open_numbers(id_, name);
  if (!dataset.good()) return cannot_read(file_, name);
  const auto dims = shape_of(dataset);
  if (dims.empty() || row >= dims[0])
    return Error{fmt::format("{}: \"{}\" has {} rows; row {} was asked for.", file_.string(), name,
                             dims.empty() ? 0 : dims[0], row)};
  std::vector<double> values(row_length(dims));
  const Handle rows = row_selection(dataset, row, dims);
  const hsize_t size = values.size();
  const Handle memory(H5Screate_simple(1, &size, nullptr), H5Sclose);
  if (H5Dread(dataset, H5T_NATIVE_DOUBLE, memory, rows, H5P_DEFAULT, values.data()) < 0)
    return cannot_read(file_, name);
  return values;
}

Result<std::vector<std::string>> Hdf5File::read_texts(const std::string& name) const {
  const Handle dataset = open_dataset(id_, name);
  if (!dataset.good()) return cannot_read(file_, name);
  const auto dims = shape_of(dataset);
  const Handle stored(H5Dget_type(dataset), H5Tclose);
  if (dims.size() != 1 || !stored_as_claimed(dataset) || H5Tis_variable_str(stored) <= 0)
    return cannot_read(file_, name);
  std::vector<char*> pointers(dims[0]);
  const Handle type = text_type();
  if (H5Dread(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, pointers.data()) < 0) return cannot_read(file_, name);
  std::vector<std::string> texts;
  for (const char* pointer : pointers) texts.emplace_back(pointer != nullptr ? pointer : "");
  const Handle space(H5Dget_space(dataset), H5Sclose);
  H5Dvlen_reclaim(type, space, H5P_DEFAULT, pointers.data());
  return texts;
}

Result<std::string> Hdf5File::text_attribute(const std::string& name, const std::string& key) const {
  if (!exists(id_, name)) return cannot_read(file_, name);
  const Handle attribute = open_attribute(id_, name, key);
  if (!attribute.good()) return cannot_read(file_, name + " @" + key);
  const Handle stored(H5Aget_type(attribute), H5Tclose), type = text_type();
  if (H5Tis_variable_str(stored) <= 0) return cannot_read(file_, name + " @" + key);
  char* pointer = nullptr;
  if (H5Aread(attribute, type, &pointer) < 0 || pointer == nullptr) return cannot_read(file_, name + " @" + key);
  std::string text(pointer);
  H5free_memory(pointer);
  return text;
}

Result<double> Hdf5File::number_attribute(const std::string& name, const std::string& key) const {
  if (!exists(id_, name)) return cannot_read(file_, name);
  const Handle attribute = open_attribute(id_, name, key);
  double value = 0.0;
  if (!attribute.good() || H5Aread(attribute, H5T_NATIVE_DOUBLE, &value) < 0)
    return cannot_read(file_, name + " @" + key);
  return value;
}

Result<std::vector<std::string>> Hdf5File::children(const std::string& group) const {
  if (!exists(id_, group)) return cannot_read(file_, group);
  const Handle opened(H5Gopen2(id_, group.empty() ? "/" : group.c_str(), H5P_DEFAULT), H5Gclose);
  if (!opened.good()) return cannot_read(file_, group);
  std::vector<std::string> names;
  const auto collect = [](hid_t, const char* name, const H5L_info_t*, void* list) -> herr_t {
    static_cast<std::vector<std::string>*>(list)->emplace_back(name);
    return 0;
  };
  if (H5Literate(opened, H5_INDEX_NAME, H5_ITER_INC, nullptr, collect, &names) < 0) return cannot_read(file_, group);
  return names;
}

Status Hdf5File::flush() {
  if (H5Fflush(id_, H5F_SCOPE_LOCAL) < 0) return failed_to_write("/");
  return {};
}

Status Hdf5File::sync() {
  if (sealed_ && !sealed_->sync()) return failed_to_write("/");
  return {};
}

}  // namespace granary
