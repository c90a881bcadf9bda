#include "dem_templates/plugin/resize/population.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "common/json/io.hpp"
#include "common/json/reader.hpp"

namespace granary::dem {
namespace {

using json::Range;

constexpr double kMostParticles = 1e8;

CompartmentPopulation read_compartment(json::Reader& reader) {
  CompartmentPopulation compartment{.from = reader.number("from_m"), .to = reader.number("to_m"), .diameters = {}};
  if (compartment.to <= compartment.from) reader.problem("to_m", "must be larger than from_m.");
  const std::vector<double> diameters = reader.numbers("diameters_m", Range::positive());
  const std::vector<double> counts = reader.numbers("counts", Range::between(0.0, kMostParticles));
  reader.done();
  if (diameters.size() != counts.size()) {
    reader.problem("counts", "must be as many as diameters_m.");
    return compartment;
  }
  for (std::size_t k = 0; k < diameters.size(); ++k) {
    if (counts[k] != std::floor(counts[k])) reader.problem("counts", "must be whole numbers.");
    compartment.diameters.insert(compartment.diameters.end(), static_cast<std::size_t>(counts[k]), diameters[k]);
  }
  std::sort(compartment.diameters.begin(), compartment.diameters.end());
  return compartment;
}

}  // namespace

double CompartmentPopulation::volume() const {
  double cubes = 0.0;
  for (double d : diameters) cubes += d * d * d;
  return std::numbers::pi / 6.0 * cubes;
}

double ResizePopulation::largest_diameter() const {
  double largest = 0.0;
  for (const CompartmentPopulation& compartment : compartments)
    if (!compartment.diameters.empty()) largest = std::max(largest, compartment.diameters.back());
  return largest;
}

double ResizePopulation::volume() const {
  double sum = 0.0;
  for (const CompartmentPopulation& compartment : compartments) sum += compartment.volume();
  return sum;
}

Result<ResizePopulation> read_population(const std::filesystem::path& file) {
  GRANARY_TRY(const json::Value document, json::read_file(file));
  json::Problems problems;
  json::Reader reader(document, file.string(), problems);
  reader.choice("format", {"granary-population-1"});
  ResizePopulation population;
  population.density = reader.number("density_kg_m3", Range::positive());
  reader.number_or("coarse_graining", 1.0, Range::positive());
  for (json::Reader& item : reader.items("compartments")) population.compartments.push_back(read_compartment(item));
  if (population.compartments.empty()) reader.problem("compartments", "must list at least one compartment.");
  reader.done();
  for (std::size_t c = 1; c < population.compartments.size(); ++c)
    if (population.compartments[c].from < population.compartments[c - 1].to)
      reader.problem("compartments", "must follow each other along the axis without overlap.");
  if (!problems.empty()) return problems.error();
  if (population.largest_diameter() == 0.0)
    return Error{file.string() +
                 ": /compartments ask for no particles at all. At least one compartment must hold some."};
  return population;
}

}  // namespace granary::dem
