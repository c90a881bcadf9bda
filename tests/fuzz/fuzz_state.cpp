// Any file to restart from: any bytes; a real checkpoint with damage; and a whole HDF5 file under a right seal whose
// datasets and attributes are of any kind, shape, size and value. Each is refused with a message, or gives a state that
// is finite and not negative.
#include <fuzzer/FuzzedDataProvider.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <sstream>

#include "common/results/hdf5_handle.hpp"
#include "common/results/sealed_driver.hpp"
#include "pbm_solver/model/model_tables.hpp"
#include "pbm_solver/output/state_file.hpp"
#include "tests/fuzz/fuzz_support.hpp"

namespace {

using namespace granary;
using fuzz::demand;
namespace fs = std::filesystem;

constexpr hsize_t kRows = 2;
constexpr double kRoundOff = 1e-12;

pbm::PbmCase small_case() {
  pbm::PbmCase c;
  c.grid = {{3, 2}, {1.0, 1.0}, {3.0, 3.0}};
  c.compartments = {2, {1.0, 1.0}, 10.0};
  c.initial = {{-1, 0, 1, 5.0, 0.5, 0.25}};
  return c;
}

const fuzz::OwnFile& place() {
  static const fuzz::OwnFile one("state.h5");
  return one;
}

const std::string& a_checkpoint() {
  static const std::string bytes = [] {
    const pbm::PbmCase c = small_case();
    const pbm::ClassGrid grid(c.grid);
    demand(pbm::write_checkpoint(place().path(), c, grid, pbm::initial_snapshot(c, grid)).has_value(), "it is written");
    std::ifstream in(place().path(), std::ios::binary);
    std::stringstream text;
    text << in.rdbuf();
    return text.str();
  }();
  return bytes;
}

void all_fine(const std::vector<double>& values, std::size_t size, bool may_be_negative) {
  demand(values.size() == size, "an accepted state has the shape of its grid");
  double largest = 0.0;
  for (const double v : values) largest = std::max(largest, v);
  for (const double v : values)
    demand(std::isfinite(v) && (may_be_negative || v >= -kRoundOff * largest), "a state is finite and not negative");
}

/// Whether it is accepted.
bool try_it(std::optional<double> time) {
  const pbm::PbmCase c = small_case();
  const pbm::ClassGrid grid(c.grid);
  const auto read = pbm::read_restart(pbm::Restart{place().path(), time}, c, grid);
  if (!read) {
    demand(read.error().message.find("state.h5") != std::string::npos, "a refusal names the file");
    return false;
  }
  const auto n_compartments = static_cast<std::size_t>(c.compartments.count);
  for (const auto* field : {&read->number, &read->liquid, &read->gas})
    all_fine(*field, n_compartments * grid.size(), false);
  all_fine(read->ledger, n_compartments * pbm::ledger::kSize, true);
  all_fine({read->time}, 1, true);
  all_fine({read->next_step, read->last_error}, 2, false);
  pbm::summarize(*read, c, grid);
  return true;
}

// ---- damage

void try_damaged(FuzzedDataProvider& choices) {
  std::string bytes = a_checkpoint();
  const std::string whole = bytes;
  if (choices.ConsumeBool()) bytes.resize(choices.ConsumeIntegralInRange<std::size_t>(0, bytes.size()));
  while (!bytes.empty() && choices.remaining_bytes() > 0)
    bytes[choices.ConsumeIntegralInRange<std::size_t>(0, bytes.size() - 1)] = choices.ConsumeIntegral<char>();
  place().put(bytes);
  const bool accepted = try_it({});
  // One of the two seals may be lost; a changed byte behind them may not go unseen.
  if (bytes.size() < whole.size() || bytes.substr(SealedBytes::kHead) != whole.substr(SealedBytes::kHead))
    demand(!accepted, "damage is seen");
}

// ---- whole files of any content

double any_value(FuzzedDataProvider& choices) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  static const std::array kPool{0.0,   1.0,    2.5,    -1.0,      -0.0,       -1e-15,
                                1e308, -1e308, 5e-324, kInfinity, -kInfinity, std::nan("")};
  return choices.ConsumeBool() ? choices.PickValueInArray(kPool) : choices.ConsumeFloatingPoint<double>();
}

/// A type that a dataset or attribute could have, among them those it must not have.
Handle any_type(FuzzedDataProvider& choices) {
  const auto copy = [](hid_t of) { return Handle(H5Tcopy(of), H5Tclose); };
  switch (choices.ConsumeIntegralInRange(0, 13)) {
    case 0:
      return copy(H5T_NATIVE_FLOAT);
    case 1:
      return copy(H5T_NATIVE_INT8);
    case 2:
      return copy(H5T_NATIVE_UINT64);
    case 3:
      return copy(H5T_NATIVE_LDOUBLE);
    case 4:
      return copy(H5T_IEEE_F64BE);
    case 5:
      return text_type();
    case 6: {
      Handle fixed = copy(H5T_C_S1);
      H5Tset_size(fixed, choices.ConsumeIntegralInRange<std::size_t>(1, 40));
      return fixed;
    }
    case 7: {
      Handle pair(H5Tcreate(H5T_COMPOUND, 16), H5Tclose);
      H5Tinsert(pair, "r", 0, H5T_NATIVE_DOUBLE);
      H5Tinsert(pair, "i", 8, H5T_NATIVE_DOUBLE);
      return pair;
    }
    case 8: {
      const hsize_t n = choices.ConsumeIntegralInRange<hsize_t>(1, 9);
      return {H5Tarray_create2(H5T_NATIVE_DOUBLE, 1, &n), H5Tclose};
    }
    case 9:
      return {H5Tvlen_create(H5T_NATIVE_DOUBLE), H5Tclose};
    case 10:
      return {H5Tcreate(H5T_OPAQUE, 8), H5Tclose};
    case 11:
      return copy(H5T_STD_REF_OBJ);
    case 12:
      return copy(H5T_NATIVE_B64);
    default:
      return copy(H5T_NATIVE_DOUBLE);
  }
}

std::vector<hsize_t> any_shape(FuzzedDataProvider& choices) {
  std::vector<hsize_t> dims(choices.ConsumeIntegralInRange<std::size_t>(0, 5));
  for (hsize_t& d : dims)
    d = choices.ConsumeIntegralInRange(0, 9) == 0 ? choices.ConsumeIntegral<std::uint32_t>()
                                                  : choices.ConsumeIntegralInRange(0, 4);
  return dims;
}

/// How the values are stored; a dataset that only claims to have values gets none.
Handle any_layout(FuzzedDataProvider& choices, const std::vector<hsize_t>& dims) {
  Handle properties(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
  const int kind = choices.ConsumeIntegralInRange(0, 7);
  if (kind == 0) H5Pset_layout(properties, H5D_COMPACT);
  if (kind == 1) H5Pset_external(properties, "/dev/zero", 0, H5F_UNLIMITED);
  if (kind >= 4 && !dims.empty()) {
    std::vector<hsize_t> chunk = dims;
    for (hsize_t& d : chunk) d = std::max<hsize_t>(1, choices.ConsumeBool() ? d : choices.ConsumeIntegralInRange(1, 9));
    H5Pset_chunk(properties, static_cast<int>(chunk.size()), chunk.data());
    if (kind == 7) H5Pset_deflate(properties, 1);
  }
  return properties;
}

void write_values(FuzzedDataProvider& choices, hid_t dataset, const std::vector<hsize_t>& dims, bool plain) {
  hsize_t n = 1;
  for (const hsize_t d : dims) n = d == 0 || n > 4096 ? 0 : n * d;
  if (n == 0 || n > 4096) return;
  std::vector<double> values(n, plain ? 1.0 : 0.0);
  if (plain) {
    for (std::size_t row = 0; row < n; ++row) values[row] = dims.size() == 1 ? static_cast<double>(row) : 1.0;
    for (int k = choices.ConsumeIntegralInRange(0, 3); k > 0; --k)
      values[choices.ConsumeIntegralInRange<std::size_t>(0, n - 1)] = any_value(choices);
  } else {
    for (double& v : values) v = any_value(choices);
  }
  H5Dwrite(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
}

void add_dataset(FuzzedDataProvider& choices, hid_t file, const char* name, std::vector<hsize_t> dims) {
  const Handle links(H5Pcreate(H5P_LINK_CREATE), H5Pclose);
  H5Pset_create_intermediate_group(links, 1);
  // 0, which is what a choice gives when the bytes have run out, is the dataset as it should be.
  const int kind = choices.ConsumeIntegralInRange(0, 20);
  if (kind == 1) return;
  if (kind == 2) return void(H5Gclose(H5Gcreate2(file, name, links, H5P_DEFAULT, H5P_DEFAULT)));
  if (kind == 3)
    return void(H5Lcreate_soft(choices.ConsumeBool() ? name : "/state/time", file, name, links, H5P_DEFAULT));
  if (kind == 4) return void(H5Lcreate_external("/dev/zero", "/state/time", file, name, links, H5P_DEFAULT));
  const bool other_type = kind == 5, other_shape = kind == 6, other_layout = kind == 7;
  if (other_shape) dims = any_shape(choices);
  const Handle type = other_type ? any_type(choices) : Handle(H5Tcopy(H5T_NATIVE_DOUBLE), H5Tclose);
  const Handle space(H5Screate_simple(static_cast<int>(dims.size()), dims.data(), nullptr), H5Sclose);
  const Handle layout = other_layout ? any_layout(choices, dims) : Handle(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
  const Handle dataset(H5Dcreate2(file, name, type, space, links, layout, H5P_DEFAULT), H5Dclose);
  if (dataset.good()) write_values(choices, dataset, dims, !other_shape);
}

/// The pivots of the small case, so that a state gets past the look at the grid.
void add_grid(FuzzedDataProvider& choices, hid_t file, const char* name, const pbm::SolidAxis& axis) {
  if (choices.ConsumeIntegralInRange(0, 9) == 1) return add_dataset(choices, file, name, {axis.pivots().size()});
  const Handle links(H5Pcreate(H5P_LINK_CREATE), H5Pclose);
  H5Pset_create_intermediate_group(links, 1);
  const hsize_t n = axis.pivots().size();
  const Handle space(H5Screate_simple(1, &n, nullptr), H5Sclose);
  const Handle dataset(H5Dcreate2(file, name, H5T_NATIVE_DOUBLE, space, links, H5P_DEFAULT, H5P_DEFAULT), H5Dclose);
  H5Dwrite(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, axis.pivots().data());
}

void add_format(FuzzedDataProvider& choices, hid_t file) {
  const int kind = choices.ConsumeIntegralInRange(0, 9);
  if (kind == 1) return;
  const bool odd = kind == 2;
  const Handle type = odd ? any_type(choices) : text_type();
  const hsize_t n = odd ? choices.ConsumeIntegralInRange<hsize_t>(0, 5) : 1;
  const Handle space(odd ? H5Screate_simple(1, &n, nullptr) : H5Screate(H5S_SCALAR), H5Sclose);
  const Handle attribute(H5Acreate2(file, "format", type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  const std::string text = kind == 3 ? choices.ConsumeRandomLengthString(60) : "granary-pbm-out-1";
  const char* pointer = text.c_str();
  if (!odd) H5Awrite(attribute, type, &pointer);
}

/// Whether it is accepted.
bool try_built(FuzzedDataProvider& choices) {
  const pbm::PbmCase c = small_case();
  const pbm::ClassGrid grid(c.grid);
  const std::optional<double> time = choices.ConsumeBool() ? std::optional(any_value(choices)) : std::nullopt;
  {
    auto bytes = SealedBytes::create(place().path());
    demand(bytes.has_value(), "the file is made");
    const Handle file(create_in(*bytes), H5Fclose);
    add_format(choices, file);
    add_grid(choices, file, "/grid/solid_1", grid.axis(0));
    add_grid(choices, file, "/grid/solid_2", grid.axis(1));
    for (const char* scalar : {"/state/time", "/state/next_step", "/state/last_error"})
      add_dataset(choices, file, scalar, {kRows});
    for (const char* field : {"/state/number", "/state/liquid", "/state/gas"})
      add_dataset(choices, file, field, {kRows, 2, 3, 2});
    add_dataset(choices, file, "/state/ledger", {kRows, 2 * pbm::ledger::kSize});
  }
  return try_it(time);
}

}  // namespace

extern "C" int LLVMFuzzerInitialize(int*, char***) {
  demand(!a_checkpoint().empty() && try_it({}), "a real checkpoint is accepted");
  FuzzedDataProvider no_choice(nullptr, 0);
  demand(try_built(no_choice), "a built file with nothing wrong is accepted");
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  // The kind stands first, so that a corpus can hold plain files behind it.
  const std::uint8_t kind = data[0];
  FuzzedDataProvider choices(data + 1, size - 1);
  if (kind == 'b') {
    try_built(choices);
  } else if (kind == 'd') {
    try_damaged(choices);
  } else {
    place().put({reinterpret_cast<const char*>(data + 1), size - 1});
    try_it({});
  }
  return 0;
}
