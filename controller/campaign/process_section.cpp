// feed, charge, process, spray: what goes in and when, what is in the machine at the start, how long it stays.
#include <fmt/format.h>

#include <cmath>
#include <set>

#include "common/json/reader.hpp"
#include "controller/campaign/powder.hpp"
#include "controller/campaign/sections.hpp"

namespace granary::campaign {
namespace {

using json::Range;

/// Particles of a section "feed" or "charge", scaled so that their solids have the mass (or mass per time) asked for.
struct Powder {
  std::vector<pbm::ClassRate> classes;
  double mass = 0.0;  ///< [kg] or [kg/s]
  double porosity = 0.0;

  /// Gas in one particle of a class [m^3].
  double gas(const pbm::Grid& grid, const pbm::ClassRate& fed) const {
    return (pivot(grid, 0, fed.i) + pivot(grid, 1, fed.j)) * porosity / (1.0 - porosity);
  }
};

/// One item of "classes": [i, j, share], i and j counted from 1 as in the literature; nothing if it is wrong.
std::optional<pbm::ClassRate> read_class(const json::Value& item, const json::Reader& powder, std::size_t at,
                                         const pbm::Grid& grid, json::Problems& problems) {
  const std::string place = fmt::format("{}/{}", powder.pointer("classes"), at);
  if (!item.is_array() || item.size() != 3) {
    problems.add({powder.file(), place, "",
                  "it must be [i, j, share]: the class of solid 1, of solid 2, and its share of the particles.", ""});
    return std::nullopt;
  }
  const json::Value parts =
      json::Value::object({{"0", item.items()[0]}, {"1", item.items()[1]}, {"2", item.items()[2]}});
  json::Reader reader(parts, powder.file(), problems, place);
  bool inside = true;
  const auto index = [&](const std::string& key, int bins) {
    const auto written = reader.integer_or(key, 0);
    inside = inside && written >= 1 && written <= bins;
    if (written < 1 || written > bins)
      reader.problem(key, fmt::format("it is outside the grid, whose classes are 1 to {}.", bins), "See /pbm/bins.");
    return static_cast<int>(written - 1);
  };
  const int i = index("0", grid.bins[0]);
  const int j = index("1", grid.bins[1]);
  const double share = reader.number_or("2", 0.0, Range::positive());
  if (!inside || !(share > 0.0)) return std::nullopt;
  return pbm::ClassRate{i, j, share};
}

void read_class_list(json::Reader& powder, const json::Value& list, const pbm::Grid& grid,
                     std::vector<pbm::ClassRate>& classes, json::Problems& problems) {
  if (list.size() == 0) powder.problem("classes", "it names no class.", "Add at least one, such as [1, 1, 1.0].");
  std::set<std::pair<int, int>> seen;
  for (std::size_t at = 0; at < list.size(); ++at) {
    const auto fed = read_class(list.items()[at], powder, at, grid, problems);
    if (!fed) continue;
    if (!seen.insert({fed->i, fed->j}).second)
      powder.problem("classes", fmt::format("class [{}, {}] is listed twice.", fed->i + 1, fed->j + 1),
                     "Give each class once.");
    classes.push_back(*fed);
  }
}

void read_classes(json::Reader& powder, const pbm::Grid& grid, std::vector<pbm::ClassRate>& classes,
                  json::Problems& problems) {
  const json::Value* written = powder.raw("classes");
  if (written != nullptr && written->is_array()) return read_class_list(powder, *written, grid, classes, problems);
  if (written != nullptr && !(written->is_string() && written->as_string() == "cm5")) {
    powder.problem("classes", "it must be \"cm5\" (the published feed) or a list of [i, j, share].");
    return;
  }
  auto published = published_feed(grid);
  if (published)
    classes = *published;
  else
    powder.problem("classes", published.error().message, "Widen the grid, or list your own classes.");
}

Powder read_powder(json::Reader& reader, const char* amount, const char* unit, const Campaign& campaign,
                   json::Problems& problems) {
  const pbm::Grid& grid = campaign.pbm_case.grid;
  Powder powder;
  powder.mass = reader.quantity(amount, unit, Range::positive());
  powder.porosity = reader.number_or("porosity", 0.5, {0.0, 1.0, true, false});
  read_classes(reader, grid, powder.classes, problems);
  const double mass = solid_mass(powder.classes, grid, campaign.pbm_case.materials);
  for (pbm::ClassRate& fed : powder.classes) fed.rate *= powder.mass / mass;
  return powder;
}

std::optional<Powder> read_feed(json::Reader& root, Campaign& campaign, json::Problems& problems) {
  auto reader = root.optional_section("feed");
  if (!reader) return std::nullopt;
  const Powder powder = read_powder(*reader, "rate", "kg/s", campaign, problems);
  pbm::Feed feed{powder.classes, powder.porosity};
  feed.start = reader->quantity_or("start", feed.start, "s", Range::not_negative());
  feed.end = reader->quantity_or("end", feed.end, "s", Range::positive());
  if (reader->has("end") && feed.end <= feed.start)
    reader->problem("end", "it must be later than the start of the feed.");
  reader->done();
  campaign.feed_rate = powder.mass;
  campaign.pbm_case.feed = feed;
  return powder;
}

std::optional<Powder> read_charge(json::Reader& root, Campaign& campaign, json::Problems& problems) {
  auto reader = root.optional_section("charge");
  if (!reader) return std::nullopt;
  const Powder powder = read_powder(*reader, "mass", "kg", campaign, problems);
  reader->done();
  return powder;
}

/// Every compartment alike: `share` of the powder's particles in each.
void fill(Campaign& campaign, const Powder& powder, double share) {
  for (const pbm::ClassRate& fed : powder.classes) {
    const double number = fed.rate * share;
    campaign.pbm_case.initial.push_back(
        {-1, fed.i, fed.j, number, 0.0, number * powder.gas(campaign.pbm_case.grid, fed)});
  }
}

void read_start(json::Reader& process, Campaign& campaign, const std::optional<Powder>& feed,
                const std::optional<Powder>& charge) {
  const std::string initial =
      process.choice_or("initial", charge ? "charge" : "hold-up", {"hold-up", "charge", "empty"});
  const pbm::Compartments& compartments = campaign.pbm_case.compartments;
  if (initial == "charge") {
    if (charge)
      fill(campaign, *charge, 1.0 / compartments.count);
    else
      process.problem("initial", "there is no charge to start from.", R"(Add "charge": {"mass": "30 g"}.)");
  } else if (initial == "hold-up") {
    if (feed && compartments.residence_time)
      fill(campaign, *feed, *compartments.residence_time / compartments.count);
    else
      process.problem("initial",
                      "\"hold-up\", what a steady feed leaves in the machine, needs a feed and a residence_time.",
                      R"(Give /feed and /process/residence_time, or a "charge" for a batch.)");
  }
}

/// Mass of the solids that the liquid is for, per time: the feed's, or the charge's over the time of the spray [kg/s].
double sprayed_solids(json::Reader& spray, const pbm::Spray& times, const std::optional<Powder>& feed,
                      const std::optional<Powder>& charge) {
  if (feed) return feed->mass;
  if (charge && spray.has("end")) return charge->mass / (times.end - times.start);
  spray.problem(
      "liquid_to_solid",
      charge ? "for a charge it needs the end of the spray too." : "it needs a feed or a charge to relate to.",
      charge ? "Give /spray/end." : "Give the liquid as /spray/rate.");
  return 0.0;
}

void read_spray(json::Reader& root, Campaign& campaign, const std::optional<Powder>& feed,
                const std::optional<Powder>& charge) {
  auto reader = root.optional_section("spray");
  if (!reader) return;
  pbm::Spray spray;
  spray.start = reader->quantity_or("start", spray.start, "s", Range::not_negative());
  spray.end = reader->quantity_or("end", spray.end, "s", Range::positive());
  if (reader->has("end") && spray.end <= spray.start)
    reader->problem("end", "it must be later than the start of the spray.");
  const int count = campaign.pbm_case.compartments.count;
  const auto compartment = reader->integer_or("compartment", 1);
  if (compartment < 1 || compartment > count)
    reader->problem("compartment", fmt::format("there is no such compartment: they are 1 to {}.", count),
                    "See /machine/compartments.");
  else
    spray.compartment = static_cast<int>(compartment - 1);

  const bool ratio = reader->has("liquid_to_solid");
  if (ratio == reader->has("rate")) {
    reader->problem("rate", ratio ? "give either a rate or liquid_to_solid, not both."
                                  : "it is missing: give either a rate or liquid_to_solid.");
  } else if (ratio) {
    const double value = reader->number("liquid_to_solid", Range::positive());
    spray.rate = value * sprayed_solids(*reader, spray, feed, charge) / campaign.pbm_case.materials.liquid_density;
  } else {
    spray.rate = reader->quantity("rate", "m^3/s", Range::positive());
  }
  reader->done();
  campaign.pbm_case.spray = spray;
}

}  // namespace

void read_process(json::Reader& root, Campaign& campaign, json::Problems& problems) {
  const auto feed = read_feed(root, campaign, problems);
  const auto charge = read_charge(root, campaign, problems);
  const json::Value* written = root.raw("process");
  if (written == nullptr) {
    root.problem("process", "it is missing and must be given.",
                 R"(Add for example "process": {"duration": "100 s", "residence_time": "49 s"}.)");
  } else {
    json::Reader process(*written, root.file(), problems, root.pointer("process"));
    campaign.duration = process.quantity("duration", "s", Range::positive());
    campaign.pbm_case.end_time = campaign.duration;
    if (process.has("residence_time"))
      campaign.pbm_case.compartments.residence_time = process.quantity("residence_time", "s", Range::positive());
    read_start(process, campaign, feed, charge);
    process.done();
  }
  read_spray(root, campaign, feed, charge);
}

}  // namespace granary::campaign
