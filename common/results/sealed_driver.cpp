#include "common/results/sealed_driver.hpp"

#include <algorithm>
#include <iterator>
#include <memory>

namespace granary {
namespace {

/// HDF5's handle of an open file; it hands back a pointer to the first member.
struct Driver {
  H5FD_t base{};
  SealedBytes* bytes = nullptr;
  haddr_t end_of_allocated = 0;
};

/// How a file is named to the driver: by where its bytes are.
struct Access {
  SealedBytes* bytes = nullptr;
};

Driver& of(H5FD_t* file) { return *reinterpret_cast<Driver*>(file); }
const Driver& of(const H5FD_t* file) { return *reinterpret_cast<const Driver*>(file); }

H5FD_t* open_driver(const char*, unsigned, hid_t access, haddr_t) {
  const auto* named = static_cast<const Access*>(H5Pget_driver_info(access));
  if (named == nullptr) return nullptr;
  auto driver = std::make_unique<Driver>();
  driver->bytes = named->bytes;
  return &driver.release()->base;
}

herr_t close_driver(H5FD_t* file) {
  delete &of(file);
  return 0;
}

herr_t query(const H5FD_t*, unsigned long* flags) {
  *flags = H5FD_FEAT_AGGREGATE_METADATA | H5FD_FEAT_AGGREGATE_SMALLDATA | H5FD_FEAT_DEFAULT_VFD_COMPATIBLE;
  return 0;
}

haddr_t end_of_allocated(const H5FD_t* file, H5FD_mem_t) { return of(file).end_of_allocated; }

herr_t set_end_of_allocated(H5FD_t* file, H5FD_mem_t, haddr_t end) {
  of(file).end_of_allocated = end;
  return 0;
}

/// 0 if there is nothing behind the head yet: by that HDF5 knows a new file.
haddr_t end_of_file(const H5FD_t* file, H5FD_mem_t) {
  const std::uint64_t size = of(file).bytes->size();
  return size > SealedBytes::kHead ? size : 0;
}

herr_t read_bytes(H5FD_t* file, H5FD_mem_t, hid_t, haddr_t at, std::size_t size, void* to) {
  return of(file).bytes->read(at, size, static_cast<char*>(to)) ? 0 : -1;
}

herr_t write_bytes(H5FD_t* file, H5FD_mem_t, hid_t, haddr_t at, std::size_t size, const void* from) {
  return of(file).bytes->write(at, size, static_cast<const char*>(from)) ? 0 : -1;
}

herr_t flush(H5FD_t* file, hid_t, hbool_t) {
  // A file opened to be read has nothing to commit.
  return !of(file).bytes->writable() || of(file).bytes->commit(of(file).end_of_allocated) ? 0 : -1;
}

hid_t driver_id() {
  static const H5FD_class_t description = [] {
    H5FD_class_t d{};
    d.name = "granary-sealed";
    d.maxaddr = (haddr_t{1} << 62) - 1;
    d.fc_degree = H5F_CLOSE_WEAK;
    d.fapl_size = sizeof(Access);
    d.open = open_driver;
    d.close = close_driver;
    d.query = query;
    d.get_eoa = end_of_allocated;
    d.set_eoa = set_end_of_allocated;
    d.get_eof = end_of_file;
    d.read = read_bytes;
    d.write = write_bytes;
    d.flush = flush;
    const H5FD_mem_t map[] = H5FD_FLMAP_DICHOTOMY;
    std::copy(std::begin(map), std::end(map), d.fl_map);
    return d;
  }();
  static const hid_t id = H5FDregister(&description);
  return id;
}

/// Opens or makes the file with the access properties that name its bytes.
template <class Open>
hid_t with_access(SealedBytes& bytes, Open open) {
  const hid_t access = H5Pcreate(H5P_FILE_ACCESS);
  const Access named{&bytes};
  const hid_t id = H5Pset_driver(access, driver_id(), &named) < 0 ? -1 : open(access);
  H5Pclose(access);
  return id;
}

}  // namespace

hid_t create_in(SealedBytes& bytes) {
  return with_access(bytes, [](hid_t access) {
    const hid_t layout = H5Pcreate(H5P_FILE_CREATE);
    H5Pset_userblock(layout, SealedBytes::kHead);
    const hid_t id = H5Fcreate("sealed", H5F_ACC_TRUNC, layout, access);
    H5Pclose(layout);
    return id;
  });
}

hid_t open_in(SealedBytes& bytes) {
  return with_access(bytes, [](hid_t access) { return H5Fopen("sealed", H5F_ACC_RDONLY, access); });
}

}  // namespace granary
