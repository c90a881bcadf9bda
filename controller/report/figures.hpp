// The figures of the report: what is drawn of which results, in what units, and what is said below it.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "common/results/campaign_results.hpp"
#include "controller/report/plotter.hpp"

namespace granary::report {

struct Figure {
  std::string title;
  std::string caption;  ///< how to read it
  Plot plot;            ///< its script is empty if the results hold nothing to draw
  std::string missing;  ///< then: what they do not hold
};

/// d50 with its d10-d90 band, number, porosity, liquid, hold-up and outflow over process time, by compartment.
std::vector<Figure> process_figures(const CampaignResults& results);
/// Volume density over diameter: along the granulator before and after, and through time where the granules leave.
std::vector<Figure> size_figures(const CampaignResults& results);
/// What the DEM gave: collision rates by class pair, totals by burst, speed distributions.
std::vector<Figure> rate_figures(const CampaignResults& results);
/// The DEM over its own clock: kinetic energy, particles, speeds, overlap.
std::vector<Figure> dem_figures(const CampaignResults& results);
/// What ran where and when, and how many cores were busy.
std::vector<Figure> core_figures(const CampaignResults& results);

/// Draws those that have something to draw as SVG files "FOLDER/PREFIXd50.svg". Errors: those of the plotter; a full
/// disk.
Status write_figures(const std::vector<Figure>& figures, Plotter& plotter, const std::filesystem::path& folder,
                     const std::string& prefix);

}  // namespace granary::report
