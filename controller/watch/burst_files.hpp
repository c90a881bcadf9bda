// What the bursts' programs write while they run: sizes from progress.jsonl, contacts from tallies.jsonl.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "common/json/io.hpp"
#include "controller/watch/view.hpp"

namespace granary::watch {

class BurstFiles {
 public:
  explicit BurstFiles(std::filesystem::path dir) : dir_(std::move(dir)) {}

  /// Reads on in the files of these bursts; of those that are over, once.
  void follow(const std::vector<Burst>& bursts);

  /// In the order of the bursts; of a PBM burst that is over nothing beyond where the DEM took over.
  std::vector<SizePoint> sizes(const std::vector<Burst>& bursts) const;
  std::vector<ContactPoint> contacts(const std::vector<Burst>& bursts) const;
  /// The clock of a burst at its last line [s]; unknown before there is one.
  double clock_of(const Burst& burst) const;
  /// Files that cannot be read, in words.
  std::vector<std::string> problems() const;

 private:
  struct Followed {
    int attempt = 0;
    bool closed = false;
    std::unique_ptr<json::LineReader> reader;
    std::vector<SizePoint> sizes;
    std::vector<ContactPoint> contacts;
    std::string problem;
  };
  void read(Followed& followed, bool dem);

  std::filesystem::path dir_;
  std::map<std::string, Followed> followed_;  ///< by folder
};

/// One window of tallies; nothing if the line is none (a header, a diverged record).
std::optional<ContactPoint> contact_point(const json::Value& line);
/// One output of a PBM; nothing if the line is none.
std::optional<SizePoint> size_point(const json::Value& line);

}  // namespace granary::watch
