#include "controller/watch/burst_files.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace granary::watch {

namespace {

double sum(const std::vector<double>& values) { return std::accumulate(values.begin(), values.end(), 0.0); }

/// Each unordered pair once: of a symmetric table the part p <= q.
double pairs(const json::Value& table) {
  double total = 0.0;
  std::size_t p = 0;
  for (const json::Value& row : table.items_or_none()) {
    const std::vector<double> counts = row.numbers();
    for (std::size_t q = p; q < counts.size(); ++q) total += counts[q];
    ++p;
  }
  return total;
}

}  // namespace

std::optional<ContactPoint> contact_point(const json::Value& line) {
  if (!line["particles"].is_array()) return std::nullopt;
  ContactPoint point;
  point.time = line.number_or("time_s", 0.0);
  for (const json::Value& row : line["particles"].items()) point.particles += sum(row.numbers());
  double impacts = 0.0;
  for (const auto& [body, counts] : line["impacts"].members_or_none()) impacts += sum(counts.numbers());
  const double exposure = point.particles * line.number_or("window_s", 0.0);
  if (!(exposure > 0.0)) return std::nullopt;
  point.collisions = 2.0 * pairs(line["collisions"]) / exposure;  // two particles take part in each
  point.impacts = impacts / exposure;
  return point;
}

std::optional<SizePoint> size_point(const json::Value& line) {
  if (!line["d50_m"].is_array()) return std::nullopt;
  return SizePoint{line.number_or("time_s", 0.0), line.numbers("d50_m"), line.numbers("number")};
}

void BurstFiles::follow(const std::vector<Burst>& bursts) {
  for (const Burst& burst : bursts) {
    Followed& followed = followed_[burst.folder];
    if (followed.attempt != burst.attempt) {
      followed = {};
      followed.attempt = burst.attempt;
      followed.reader = std::make_unique<json::LineReader>(dir_ / "bursts" / burst.folder /
                                                           (burst.dem ? "tallies.jsonl" : "progress.jsonl"));
    }
    if (!followed.closed) read(followed, burst.dem);
    // Its last lines are there before the journal says where it ended.
    followed.closed = !std::isnan(burst.end) || !followed.problem.empty();
  }
}

void BurstFiles::read(Followed& followed, bool dem) {
  const auto lines = followed.reader->next();
  if (!lines) {
    followed.problem = lines.error().message;
    return;
  }
  for (const json::Value& line : *lines) {
    if (const auto point = dem ? contact_point(line) : std::nullopt) followed.contacts.push_back(*point);
    if (auto point = dem ? std::nullopt : size_point(line)) followed.sizes.push_back(std::move(*point));
  }
}

std::vector<SizePoint> BurstFiles::sizes(const std::vector<Burst>& bursts) const {
  std::vector<SizePoint> all;
  for (const Burst& burst : bursts) {
    const auto found = followed_.find(burst.folder);
    if (found == followed_.end()) continue;
    for (const SizePoint& point : found->second.sizes)
      if (!(point.time > burst.end + 1e-9)) all.push_back(point);
  }
  return all;
}

std::vector<ContactPoint> BurstFiles::contacts(const std::vector<Burst>& bursts) const {
  std::vector<ContactPoint> all;
  for (const Burst& burst : bursts) {
    const auto found = followed_.find(burst.folder);
    if (found != followed_.end()) all.insert(all.end(), found->second.contacts.begin(), found->second.contacts.end());
  }
  return all;
}

double BurstFiles::clock_of(const Burst& burst) const {
  const auto found = followed_.find(burst.folder);
  if (found == followed_.end()) return kUnknown;
  if (burst.dem) return found->second.contacts.empty() ? kUnknown : found->second.contacts.back().time;
  return found->second.sizes.empty() ? kUnknown : found->second.sizes.back().time;
}

std::vector<std::string> BurstFiles::problems() const {
  std::vector<std::string> problems;
  for (const auto& [folder, followed] : followed_)
    if (!followed.problem.empty()) problems.push_back(followed.problem);
  return problems;
}

}  // namespace granary::watch
